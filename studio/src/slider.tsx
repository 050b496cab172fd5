// A slider with its name and its value, by pointer and by keys.
import { clamp } from "./math";

export type SliderProps = {
  label: string;
  value: number;
  least: number;
  most: number;
  /** What an arrow key changes; a fifth of it with Shift, ten times it with Page Up and Page Down. */
  step: number;
  digits?: number;
  unit?: string;
  /** The value in words, in the place of its digits and unit. */
  words?: string;
  /** Whether it takes multiples of `step` alone. */
  stepped?: boolean;
  /** Whether the name is for screen readers alone. */
  bare?: boolean;
  /** Whether the value can be typed. */
  entry?: boolean;
  disabled?: boolean;
  class?: string;
  onInput: (value: number) => void;
  /** The value stands; `merge` names the steps that belong together. */
  onDone: () => void;
};

const KEY_STEPS: Record<string, number> = {
  ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10,
};

export function Slider(props: SliderProps) {
  const { label, value, least, most, step, digits = 2, unit = "", stepped, bare, entry, disabled, onInput, onDone } = props;
  const text = props.words ?? `${value.toFixed(digits)}${unit}`;
  const set = (next: number) => onInput(clamp(next, least, most));
  const onKeyDown = (event: KeyboardEvent) => {
    const steps = KEY_STEPS[event.key];
    if (steps === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    set(value + steps * step * (event.shiftKey && !stepped ? 0.2 : 1));
    onDone();
  };
  const share = (100 * (clamp(value, least, most) - least)) / (most - least);
  return (
    <label class={`slider ${bare ? "bare" : ""} ${props.class ?? ""}`}>
      <span class={bare ? "hidden" : "slider-name"}>{label}</span>
      <input
        type="range"
        min={least}
        max={most}
        step={stepped ? step : "any"}
        value={value}
        disabled={disabled}
        aria-label={label}
        aria-valuetext={text}
        style={{ "--at": `${share}%` }}
        onKeyDown={onKeyDown}
        onInput={(event) => set(event.currentTarget.valueAsNumber)}
        onChange={onDone}
      />
      {entry ? <Entry {...props} text={text} set={set} /> : <output class="number">{text}</output>}
    </label>
  );
}

function Entry({ label, text, set, disabled, onDone }: SliderProps & { text: string; set: (value: number) => void }) {
  const take = (input: HTMLInputElement) => {
    const value = Number.parseFloat(input.value.replace(",", "."));
    if (Number.isFinite(value) && input.value !== text) {
      set(value);
      onDone();
    } else input.value = text;
  };
  return (
    <input
      type="text"
      inputMode="decimal"
      class="number entry"
      aria-label={`${label}, typed`}
      value={text}
      disabled={disabled}
      onFocus={(event) => event.currentTarget.select()}
      onBlur={(event) => take(event.currentTarget)}
      onKeyDown={(event) => {
        if (event.key === "Enter") take(event.currentTarget);
      }}
    />
  );
}
