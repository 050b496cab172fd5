// The dome: a map of all directions that light may come from, with the lights as handles on the landscape of F.
import { useEffect, useRef } from "preact/hooks";
import { hexOf } from "./colour";
import { choose, chosen, doc, ofLight } from "./document";
import { paint } from "./dome_map";
import { pointerMoved } from "./drawing";
import { change, commit, edit } from "./history";
import { landscape, outdated } from "./landscape";
import { inWords, intensityOf, MOST, nameOf, towards, withIntensity } from "./light";
import { angles, clamp, direction, fromDisc, toDisc, wrapped, type Vec3 } from "./math";
import type { Light, Mapped } from "./messages";
import { interrupt } from "./searching";
import { dark } from "./theme";

/** Pixels along the side of the landscape's picture. */
const PIXELS = 420;
/** Degrees that an arrow key moves a light, and with Shift. */
const STEP = { coarse: 2, fine: 0.25 };
/** Share of the pointer's way that a handle goes with Shift. */
const FINE = 0.2;
/** Share by which a notch of the wheel or a key changes the intensity, and with Shift. */
const NOTCH = { coarse: 0.06, fine: 0.012 };

/** Least gain of `F` that is spoken of. */
const WORTHWHILE = 0.003;

const move = (index: number, vector: Vec3) => edit(ofLight(index, (light) => towards(light, vector)));

function brighten(index: number, notches: number, fine: boolean) {
  const light = doc.value?.lights[index];
  if (!light) return;
  interrupt();
  const factor = Math.exp(notches * (fine ? NOTCH.fine : NOTCH.coarse));
  const intensity = Math.max(0.01, intensityOf(light)) * factor;
  change("Intensity", ofLight(index, (old) => withIntensity(old, intensity)), `intensity ${index}`);
}

function nudge(index: number, light: Light, key: string, fine: boolean): boolean {
  const ways: Record<string, [number, number]> = {
    ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1],
  };
  const way = ways[key];
  if (!way) return false;
  const step = fine ? STEP.fine : STEP.coarse;
  const { elevation, azimuth } = angles(light.direction);
  const vector = direction(clamp(elevation + way[1] * step, -90, 90), wrapped(azimuth + way[0] * step));
  interrupt();
  move(index, vector);
  commit("Move", `move ${index}`);
  return true;
}

export function remove(index: number) {
  if (!doc.value || doc.value.lights.length < 2) return;
  interrupt();
  change("Remove light", (document) => ({ ...document, lights: document.lights.filter((_, other) => other !== index) }));
}

export function lock(index: number) {
  const locked = doc.value?.lights[index]?.locked;
  change(locked ? "Unlock" : "Lock", ofLight(index, (light) => ({ ...light, locked: !locked })));
}

function onHandleKey(event: KeyboardEvent, index: number, light: Light) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const { key, shiftKey } = event;
  if (nudge(index, light, key, shiftKey)) return event.preventDefault();
  if (["+", "=", "PageUp"].includes(key)) brighten(index, 1, shiftKey);
  else if (["-", "_", "PageDown"].includes(key)) brighten(index, -1, shiftKey);
  else if (key === "Delete" || key === "Backspace") remove(index);
  else if (key === "l" || key === "L") lock(index);
  else return;
  event.preventDefault();
}

/** Begins to drag a light; the handle goes with the pointer, slowly with Shift. */
function drag(event: PointerEvent, disc: HTMLElement, index: number, start: [number, number]) {
  const light = doc.value?.lights[index];
  choose(index);
  if (!light || event.button !== 0) return;
  event.preventDefault();
  interrupt();
  const radius = disc.getBoundingClientRect().width / 2;
  let [x, y] = start;
  let [lastX, lastY] = [event.clientX, event.clientY];
  const onMove = (moved: PointerEvent) => {
    const share = (moved.shiftKey ? FINE : 1) / radius;
    [x, y] = [x + (moved.clientX - lastX) * share, y - (moved.clientY - lastY) * share];
    [lastX, lastY] = [moved.clientX, moved.clientY];
    pointerMoved(moved);
    move(index, fromDisc(x, y));
  };
  const onEnd = () => {
    disc.removeEventListener("pointermove", onMove);
    commit("Move");
  };
  disc.setPointerCapture(event.pointerId);
  disc.addEventListener("pointermove", onMove);
  disc.addEventListener("pointerup", onEnd, { once: true });
  disc.addEventListener("pointercancel", onEnd, { once: true });
}

/** Puts the chosen light where the dome is pressed; gives that place, none beyond the rim. */
function jumpTo(event: MouseEvent, disc: HTMLElement): [number, number] | null {
  const box = disc.getBoundingClientRect();
  const x = (2 * (event.clientX - box.left)) / box.width - 1;
  const y = 1 - (2 * (event.clientY - box.top)) / box.height;
  if (!doc.value?.lights[chosen.value] || event.button !== 0 || Math.hypot(x, y) > 1) return null;
  interrupt();
  pointerMoved(event);
  move(chosen.value, fromDisc(x, y));
  return [x, y];
}

/** A finger that begins beside the handles scrolls the page; only its tap moves the light. */
function onDiscDown(event: PointerEvent, disc: HTMLElement) {
  const place = event.pointerType === "touch" ? null : jumpTo(event, disc);
  if (place) drag(event, disc, chosen.value, place);
}

function onDiscClick(event: MouseEvent, disc: HTMLElement) {
  const byFinger = event instanceof PointerEvent && event.pointerType === "touch";
  if (byFinger && !(event.target as Element).closest("[data-light]") && jumpTo(event, disc)) commit("Move");
}

function Handle({ light, index, disc }: { light: Light; index: number; disc: { current: HTMLDivElement | null } }) {
  const [x, y] = toDisc(light.direction);
  const isChosen = index === chosen.value;
  const share = clamp(intensityOf(light) / MOST.intensity, 0, 1);
  return (
    <div
      class={`handle ${isChosen ? "chosen" : ""} ${light.locked ? "locked" : ""}`}
      role="slider"
      tabIndex={0}
      data-light={index}
      aria-roledescription="light on the dome"
      aria-label={nameOf(light, index)}
      aria-valuemin={-180}
      aria-valuemax={180}
      aria-valuenow={Math.round(angles(light.direction).azimuth)}
      aria-valuetext={inWords(light)}
      style={{ left: `${50 + 50 * x}%`, top: `${50 - 50 * y}%`, "--light": hexOf(light.color) }}
      onFocus={() => choose(index)}
      onKeyDown={(event) => onHandleKey(event, index, light)}
      onPointerDown={(event) => {
        event.stopPropagation();
        event.currentTarget.focus({ preventScroll: true });
        if (disc.current) drag(event, disc.current, index, [x, y]);
      }}
    >
      <svg viewBox="-16 -16 32 32" aria-hidden="true">
        <circle class="dial" r="13.500" />
        <circle class="level" r="13.500" pathLength={1} stroke-dasharray={`${share.toFixed(3)} 1`} transform="rotate(-90)" />
        <circle class="body" r="9.500" />
        <text>{index + 1}</text>
      </svg>
    </div>
  );
}

/** Circles of equal angle from the viewer; half of all directions lie within that of 90 degrees. */
const Rings = () => (
  <svg class="rings" viewBox="-100 -100 200 200" aria-hidden="true">
    {[30, 60, 120, 150].map((degrees) => (
      <circle key={degrees} r={100 * Math.sin((degrees * Math.PI) / 360)} />
    ))}
    <circle class="side" r={100 * Math.SQRT1_2} />
    <path d="M-100 0h200M0 -100v200" />
    <text y="-64">above</text>
    <text y="64">below</text>
    <text x="-57">left</text>
    <text x="56">right</text>
    <text y="-92">behind</text>
  </svg>
);

/** `F` of the map's cell in a direction; none outside its disc. */
function cellAt({ values, columns, rows }: Mapped, direction: Vec3): number | null {
  const [x, y] = toDisc(direction);
  const column = clamp(Math.floor(((1 + x) / 2) * columns), 0, columns - 1);
  const row = clamp(Math.floor(((1 - y) / 2) * rows), 0, rows - 1);
  return values[row * columns + column] ?? null;
}

/** What the map says of the chosen light. Its `F` is of small pictures, so that differences alone can be told. */
function Best() {
  const map = landscape.value;
  const light = map && doc.value?.lights[map.light];
  if (!light || outdated.value) return <p class="note">Drag a light, or click where it shall stand. Scroll for intensity.</p>;
  const [here, best] = [cellAt(map, light.direction), cellAt(map, map.best)];
  const gain = here !== null && best !== null ? here - best : 0;
  if (gain < WORTHWHILE) return <p class="note">Light {map.light + 1} stands about where it makes F lowest.</p>;
  const take = () => {
    interrupt();
    choose(map.light);
    change("Move to the best place", ofLight(map.light, (old) => towards(old, map.best)));
  };
  return (
    <p class="note">
      At the diamond F is lower by about <b>{gain.toFixed(3)}</b>.{" "}
      <button type="button" class="link" onClick={take}>
        Move light {map.light + 1} there
      </button>
    </p>
  );
}

export function Dome() {
  const disc = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const map = landscape.value;
  const scheme = dark.value;
  useEffect(() => {
    if (canvas.current) paint(canvas.current, map);
  }, [map, scheme]);
  useEffect(() => {
    const element = disc.current;
    const onWheel = (event: WheelEvent) => {
      event.preventDefault();
      const over = (event.target as Element).closest<HTMLElement>("[data-light]")?.dataset.light;
      brighten(over === undefined ? chosen.value : Number(over), -Math.sign(event.deltaY), event.shiftKey);
    };
    element?.addEventListener("wheel", onWheel, { passive: false });
    return () => element?.removeEventListener("wheel", onWheel);
  }, []);
  const best = map && !outdated.value ? toDisc(map.best) : null;
  return (
    <section class="panel dome" aria-label="Dome of light directions">
      <div class="disc" ref={disc} onPointerDown={(event) => onDiscDown(event, event.currentTarget)} onClick={(event) => onDiscClick(event, event.currentTarget)}>
        <canvas ref={canvas} width={PIXELS} height={PIXELS} aria-hidden="true" class={outdated.value ? "outdated" : ""} />
        <Rings />
        {best && <i class="best" style={{ left: `${50 + 50 * best[0]}%`, top: `${50 - 50 * best[1]}%` }} />}
        {doc.value?.lights.map((light, index) => <Handle key={index} light={light} index={index} disc={disc} />)}
      </div>
      <Best />
    </section>
  );
}
