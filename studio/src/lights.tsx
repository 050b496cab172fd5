// The list of lights, and the values of the chosen one.
import { hexOf, KELVIN, kelvinOf, linearOf, ofKelvin } from "./colour";
import { choose, chosen, doc, ofLight } from "./document";
import { lock, remove } from "./dome";
import { change, commit, edit } from "./history";
import { IconButton } from "./icons";
import {
  added, highlights, intensityOf, KINDS, MOST, nameOf, roleTitle, ROLES, towards, withHighlights, withIntensity,
} from "./light";
import { angles, clamp, direction } from "./math";
import type { Light } from "./messages";
import { interrupt } from "./searching";
import { Slider, type SliderProps } from "./slider";

const MOST_LIGHTS = 16;

function add() {
  if (!doc.value || doc.value.lights.length >= MOST_LIGHTS) return;
  interrupt();
  change("Add light", (document) => ({ ...document, lights: [...document.lights, added(document.lights)] }));
  choose(doc.value.lights.length - 1);
}

/** A slider of one value of a light. */
function Value(props: Omit<SliderProps, "onInput" | "onDone"> & { index: number; set: (light: Light, value: number) => Light }) {
  const { index, set, ...slider } = props;
  return (
    <Slider
      {...slider}
      onInput={(value) => {
        interrupt();
        edit(ofLight(index, (light) => set(light, value)));
      }}
      onDone={() => commit(props.label, `${props.label} ${index}`)}
    />
  );
}

function Colour({ light, index }: { light: Light; index: number }) {
  const kelvin = kelvinOf(light.color);
  const paint = (color: Light["color"]) => {
    interrupt();
    edit(ofLight(index, (old) => ({ ...old, color })));
  };
  return (
    <div class="colour">
      <Slider
        label="Temperature"
        class="kelvin"
        value={kelvin ?? 6500}
        least={KELVIN.least}
        most={KELVIN.most}
        step={100}
        digits={0}
        unit=" K"
        entry
        onInput={(value) => paint(ofKelvin(value))}
        onDone={() => commit("Colour", `colour ${index}`)}
      />
      <div class="row">
        <label class="swatch">
          <span>Colour</span>
          <input
            type="color"
            value={hexOf(light.color)}
            onInput={(event) => paint(linearOf(event.currentTarget.value))}
            onChange={() => commit("Colour", `colour ${index}`)}
          />
        </label>
        <button
          type="button"
          class="button"
          onClick={() => {
            paint([1, 1, 1]);
            commit("White");
          }}
        >
          White
        </button>
      </div>
    </div>
  );
}

function Choice<T extends string>(props: {
  label: string;
  value: T;
  options: [T, string][];
  onChange: (value: T) => void;
}) {
  return (
    <label class="choice">
      <span>{props.label}</span>
      <select value={props.value} onChange={(event) => props.onChange(event.currentTarget.value as T)}>
        {props.options.map(([value, title]) => <option key={value} value={value}>{title}</option>)}
      </select>
    </label>
  );
}

function Place({ light, index }: { light: Light; index: number }) {
  const { elevation, azimuth } = angles(light.direction);
  const degrees = { digits: 1, unit: "°", entry: true, index };
  return (
    <>
      <Value {...degrees} label="Elevation" value={elevation} least={-90} most={90} step={1} set={(old, value) => towards(old, direction(value, azimuth))} />
      <Value {...degrees} label="Azimuth" value={azimuth} least={-180} most={180} step={1} set={(old, value) => towards(old, direction(elevation, value))} />
      {light.kind !== "directional" && (
        <Value index={index} entry label="Distance" value={light.distance} least={0.2} most={MOST.distance} step={0.1} set={(old, distance) => ({ ...old, distance })} />
      )}
      <Value index={index} entry label="Softness" value={light.size} least={0} most={MOST.size} step={0.02} set={(old, size) => ({ ...old, size })} />
    </>
  );
}

function Cone({ light, index }: { light: Light; index: number }) {
  const degrees = { digits: 1, unit: "°", entry: true, index };
  const [inner, outer] = light.cone;
  return (
    <>
      <Value {...degrees} label="Cone" value={outer} least={1} most={89} step={1} set={(old, value) => ({ ...old, cone: [Math.min(old.cone[0], value - 0.5), value] })} />
      <Value {...degrees} label="Full within" value={inner} least={0} most={88.5} step={1} set={(old, value) => ({ ...old, cone: [clamp(value, 0, old.cone[1] - 0.5), old.cone[1]] })} />
    </>
  );
}

function Editor({ light, index }: { light: Light; index: number }) {
  const set = (label: string, values: Partial<Light>) => {
    interrupt();
    change(label, ofLight(index, (old) => ({ ...old, ...values })));
  };
  const roles: Light["role"][] = light.role === "scene" ? ["scene", ...ROLES] : ROLES;
  return (
    <div class="editor" role="group" aria-label={`Values of ${nameOf(light, index)}`}>
      <div class="row">
        <Choice label="Role" value={light.role} options={roles.map((role) => [role, roleTitle(role)])} onChange={(role) => set("Role", { role })} />
        <Choice label="Kind" value={light.kind} options={KINDS.map(({ kind, title }) => [kind, title])} onChange={(kind) => set("Kind", { kind })} />
      </div>
      <Place light={light} index={index} />
      {light.kind === "spot" && <Cone light={light} index={index} />}
      <Value index={index} entry label="Highlights" value={highlights(light)} least={0} most={2} step={0.05} set={withHighlights} />
      <Colour light={light} index={index} />
    </div>
  );
}

function Row({ light, index }: { light: Light; index: number }) {
  const isChosen = chosen.value === index;
  const name = nameOf(light, index);
  return (
    <li class={isChosen ? "light chosen" : "light"}>
      <div class="light-row">
        <button type="button" class="light-name" aria-expanded={isChosen} onClick={() => choose(index)}>
          <i class="mark" style={{ "--light": hexOf(light.color) }} aria-hidden="true">{index + 1}</i>
          <span>{roleTitle(light.role)}<span class="hidden"> light {index + 1}</span></span>
        </button>
        <Value bare index={index} label={`Intensity of ${name}`} value={intensityOf(light)} least={0} most={MOST.intensity} step={0.05} set={withIntensity} />
        <IconButton icon={light.locked ? "lock" : "unlock"} label={`Lock ${name}: searches leave it as it is`} pressed={light.locked} class="quiet" onClick={() => lock(index)} />
        <IconButton icon="close" label={`Remove ${name}`} class="quiet" disabled={doc.value?.lights.length === 1} onClick={() => remove(index)} />
      </div>
      {isChosen && <Editor light={light} index={index} />}
    </li>
  );
}

export function Lights() {
  const lights = doc.value?.lights ?? [];
  return (
    <section class="panel" aria-labelledby="lights-title">
      <div class="panel-head">
        <h2 id="lights-title">Lights</h2>
        <IconButton icon="add" label="Add a light" text="Add" disabled={lights.length >= MOST_LIGHTS} onClick={add} />
      </div>
      <ul class="lights">
        {lights.map((light, index) => <Row key={index} light={light} index={index} />)}
      </ul>
    </section>
  );
}
