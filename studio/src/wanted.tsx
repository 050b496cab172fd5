// What light is wanted: mood, brightness, contrast, and whether it may come from below.
import type { Mood } from "./messages";
import { Slider } from "./slider";
import { intent, isPlain, NOTHING, want } from "./wanting";

const STEP = 0.5;
const MOST = 2;

const MOODS: [Mood, string][] = [["soft", "Soft"], ["natural", "Natural"], ["dramatic", "Dramatic"]];

const signed = (steps: number) => (steps === 0 ? "0" : `${steps < 0 ? "−" : "+"}${Math.abs(steps)}`);

function Steps({ name, title }: { name: "brightness" | "contrast"; title: string }) {
  const value = intent.value[name];
  return (
    <Slider
      label={title}
      class="signed"
      value={value}
      words={signed(value)}
      least={-MOST}
      most={MOST}
      step={STEP}
      stepped
      onInput={(next) => {
        if (next !== intent.peek()[name]) void want({ [name]: next }, `${title} ${signed(next)}`, name);
      }}
      onDone={() => {}}
    />
  );
}

const Moods = () => (
  <div class="segments moods" role="radiogroup" aria-label="Mood">
    {MOODS.map(([mood, title]) => (
      <label key={mood}>
        <input type="radio" name="mood" value={mood} checked={intent.value.mood === mood} onChange={() => void want({ mood }, `${title} mood`, "mood")} />
        <span>{title}</span>
      </label>
    ))}
  </div>
);

function Below() {
  const onChange = (not: boolean) => void want({ below: !not }, not ? "No light from below" : "Light from below, too");
  return (
    <label class="choice">
      <input type="checkbox" checked={!intent.value.below} onChange={(event) => onChange(event.currentTarget.checked)} />
      <span>No light from below</span>
    </label>
  );
}

export const Wanted = () => (
  <section class="panel wanted" aria-labelledby="wanted-title">
    <div class="panel-head">
      <h2 id="wanted-title">Wanted</h2>
      <button type="button" class="button" disabled={isPlain.value} onClick={() => void want(NOTHING, "Nothing in particular wanted")}>
        Reset
      </button>
    </div>
    <Moods />
    <Steps name="brightness" title="Brightness" />
    <Steps name="contrast" title="Contrast" />
    <Below />
  </section>
);
