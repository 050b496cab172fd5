// What stands over the picture: tools, the camera, its shape, and what it is compared with.
import { home, lightsFollow, lookThrough } from "./camera";
import { compared, compareWith, keep, kept, manner, take } from "./comparing";
import { doc, opened, scene, shaped } from "./document";
import { change, commit } from "./history";
import { Icon, IconButton } from "./icons";
import { tool, TOOLS } from "./placing";
import { interrupt } from "./searching";
import { comparedTitle } from "./stage";

const SHAPES: [number, number][] = [[1, 1], [4, 3], [3, 2], [16, 9], [4, 5], [9, 16]];

const Tools = () => (
  <div class="segments" role="radiogroup" aria-label="What a click on the picture does">
    {TOOLS.map(({ tool: name, title, hint }) => (
      <label key={name} title={hint}>
        <input type="radio" name="tool" value={name} checked={tool.value === name} onChange={() => (tool.value = name)} />
        <Icon name={name} />
        <span>{title}</span>
      </label>
    ))}
  </div>
);

function Shape() {
  const size = doc.value?.size;
  if (!size) return null;
  const is = ([x, y]: [number, number]) => Math.abs((size[0] * y) / (size[1] * x) - 1) < 0.01;
  const known = SHAPES.find(is);
  const onChange = (value: string) => {
    const shape = SHAPES[Number(value)];
    if (!shape) return;
    interrupt();
    change("Shape of the picture", (document) => ({ ...document, size: shaped(document.size, shape) }));
  };
  return (
    <select aria-label="Shape of the picture" title="Shape of the picture" value={known ? SHAPES.indexOf(known) : -1} onChange={(event) => onChange(event.currentTarget.value)}>
      {!known && <option value={-1}>{size[0]} × {size[1]}</option>}
      {SHAPES.map(([x, y], index) => <option key={index} value={index}>{x} : {y}</option>)}
    </select>
  );
}

function Cameras() {
  const cameras = scene.value?.cameras ?? [];
  const named = doc.value?.camera.named ?? "";
  const look = (name: string) => {
    const camera = cameras.find((other) => other.name === name)?.camera;
    if (!camera) return;
    interrupt();
    void lookThrough(camera).then((done) => done && commit(`Camera ${name}`));
  };
  if (cameras.length === 0) return null;
  return (
    <select aria-label="Camera" title="Camera" value={named} onChange={(event) => look(event.currentTarget.value)}>
      {!cameras.some(({ name }) => name === named) && <option value={named}>Free camera</option>}
      {cameras.map(({ name }) => <option key={name} value={name}>{name}</option>)}
    </select>
  );
}

function Compare() {
  const presets = opened.value?.presets ?? [];
  const name = compared.value;
  return (
    <div class="row compare">
      <select
        aria-label="Compare with"
        title="Compare with"
        value={name ?? ""}
        onChange={(event) => void compareWith(event.currentTarget.value || null)}
      >
        <option value="">Compare with…</option>
        {presets.map((preset) => <option key={preset.name} value={preset.name}>{preset.title}</option>)}
        {kept.value && <option value="kept">Set aside</option>}
      </select>
      {name !== null && (
        <>
          <IconButton icon="wiper" label="With a wiper" pressed={manner.value === "wiper"} onClick={() => (manner.value = "wiper")} />
          <IconButton icon="beside" label="Side by side" pressed={manner.value === "beside"} onClick={() => (manner.value = "beside")} />
          <button type="button" class="button" onClick={() => take(comparedTitle())}>Use these</button>
          <IconButton icon="close" label="End the comparison" onClick={() => void compareWith(null)} />
        </>
      )}
      {name === null && <IconButton icon="keep" label="Set these lights aside, to compare with them" onClick={keep} />}
    </div>
  );
}

export const StageBar = () => (
  <div class="stage-bar" role="group" aria-label="Tools and comparison">
    <Tools />
    <Compare />
  </div>
);

export const ViewBar = () => (
  <div class="row view-bar" role="group" aria-label="View">
    <IconButton
      icon="home"
      label="Back to the first view"
      keys="Home"
      class="quiet"
      onClick={() => {
        interrupt();
        void home().then(() => commit("View"));
      }}
    />
    <IconButton icon="follow" label="Lights go with the camera" class="quiet" pressed={lightsFollow.value} onClick={() => (lightsFollow.value = !lightsFollow.value)} />
    <Cameras />
    <Shape />
  </div>
);
