// What light is wanted: mood, brightness, contrast, and whether it may come from below.
import { signal } from "@preact/signals";
import { doc, scene } from "./document";
import type { Mood } from "./messages";
import { Slider } from "./slider";
import { intent, isPlain, NOTHING, want, wish, wishFor, type Wish } from "./wanting";

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

/** Whether the objects are listed. */
const listed = signal(false);

const OPTIONS: [Wish, string][] = [["plain", "As all others"], ["focus", "Before all others"], ["dim", "Dim"]];

/** What is said of the objects when they are not listed. */
function summary(): string {
  const { focus = [], dim = [] } = doc.value ?? {};
  const parts = [focus.length > 0 && `${focus.join(", ")} first`, dim.length > 0 && `${dim.join(", ")} dim`];
  return parts.filter(Boolean).join("; ");
}

function Objects() {
  const objects = scene.value?.objects ?? [];
  if (objects.length < 2) return null;
  return (
    <div class="objects">
      <p class="note">
        <button type="button" class="link" aria-expanded={listed.value} onClick={() => (listed.value = !listed.value)}>
          {objects.length} objects
        </button>
        {summary() ? `: ${summary()}` : " count alike"}
      </p>
      {listed.value && (
        <ul>
          {objects.map((name) => (
            <li key={name}>
              <label class="choice">
                <span>{name}</span>
                <select value={wishFor(name)} onChange={(event) => wish(name, event.currentTarget.value as Wish)}>
                  {OPTIONS.map(([kind, title]) => <option key={kind} value={kind}>{title}</option>)}
                </select>
              </label>
            </li>
          ))}
        </ul>
      )}
    </div>
  );
}

export const Wanted = () => (
  <section class="panel wanted" aria-labelledby="wanted-title">
    <div class="panel-head">
      <h2 id="wanted-title">Wanted</h2>
      <button type="button" class="button" disabled={isPlain.value} onClick={() => void want(NOTHING, "Nothing in particular wanted", null, { focus: [], dim: [] })}>
        Reset
      </button>
    </div>
    <Moods />
    <Steps name="brightness" title="Brightness" />
    <Steps name="contrast" title="Contrast" />
    <Below />
    <Objects />
  </section>
);
