// What the terms aim at, as marks on the histogram of the picture's brightness.
import { useEffect, useRef } from "preact/hooks";
import { doc } from "./document";
import { judged, pictures } from "./drawing";
import { commit, edit } from "./history";
import { clamp } from "./math";
import type { Targets as Values } from "./messages";
import { interrupt } from "./searching";
import { dark } from "./theme";

const BINS = 64;
/** Every so many pixels one is counted. */
const STRIDE = 3;
const MOST_SPREAD = 0.5;

/** The colour behind the objects, that of all four corners; none where these differ. */
function backgroundOf(pixels: Uint32Array, width: number): number | undefined {
  const corners = [0, width - 1, pixels.length - width, pixels.length - 1].map((at) => pixels[at]);
  return corners.every((pixel) => pixel === corners[0]) ? corners[0] : undefined;
}

/** Shares of the object's pixels by brightness, sRGB-encoded; what is behind it does not count. */
function histogram({ data, width }: ImageData): Float32Array {
  const pixels = new Uint32Array(data.buffer, data.byteOffset, data.byteLength / 4);
  const background = backgroundOf(pixels, width);
  const bins = new Float32Array(BINS);
  let count = 0;
  for (let pixel = 0; pixel < pixels.length; pixel += STRIDE) {
    const at = 4 * pixel;
    if (pixels[pixel] === background || data[at + 3]! < 128) continue;
    const luma = 0.2126 * data[at]! + 0.7152 * data[at + 1]! + 0.0722 * data[at + 2]!;
    bins[Math.min(BINS - 1, Math.floor((luma * BINS) / 256))]! += 1;
    count += 1;
  }
  return bins.map((bin) => bin / Math.max(1, count));
}

function plot(canvas: HTMLCanvasElement, image: ImageData) {
  const context = canvas.getContext("2d");
  if (!context) return;
  const { width, height } = canvas;
  const bins = histogram(image);
  const most = Math.max(0.06, ...bins);
  context.clearRect(0, 0, width, height);
  context.fillStyle = getComputedStyle(canvas).color;
  context.beginPath();
  context.moveTo(0, height);
  bins.forEach((bin, index) => {
    const y = height * (1 - Math.sqrt(bin / most) * 0.94);
    context.lineTo((index * width) / BINS, y);
    context.lineTo(((index + 1) * width) / BINS, y);
  });
  context.lineTo(width, height);
  context.fill();
}

const aim = (change: Partial<Values>) => {
  interrupt();
  edit((document) => ({ ...document, targets: { ...document.targets, ...change } }));
};

type MarkProps = {
  label: string;
  class: string;
  at: number;
  value: number;
  most: number;
  /** The target's value at a place of the histogram, 0 to 1. */
  of: (place: number) => number;
  set: (value: number) => void;
};

function Mark({ label, at, value, most, of, set, ...more }: MarkProps) {
  const done = () => commit(label, label);
  const onKeyDown = (event: KeyboardEvent) => {
    const steps = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
    if (!steps) return;
    event.preventDefault();
    set(clamp(value + steps * (event.shiftKey ? 0.002 : 0.01), 0, most));
    done();
  };
  const onPointerDown = (event: PointerEvent & { currentTarget: HTMLElement }) => {
    const mark = event.currentTarget;
    const box = mark.parentElement!.getBoundingClientRect();
    mark.setPointerCapture(event.pointerId);
    mark.onpointermove = ({ clientX }) => set(clamp(of((clientX - box.left) / box.width), 0, most));
    mark.onpointerup = mark.onpointercancel = () => {
      mark.onpointermove = mark.onpointerup = mark.onpointercancel = null;
      done();
    };
  };
  return (
    <div
      class={`target ${more.class}`}
      role="slider"
      tabIndex={0}
      aria-label={label}
      aria-valuemin={0}
      aria-valuemax={most}
      aria-valuenow={Number(value.toFixed(3))}
      title={`${label}: ${value.toFixed(2)}`}
      style={{ left: `${100 * clamp(at, 0, 1)}%` }}
      onKeyDown={onKeyDown}
      onPointerDown={onPointerDown}
    />
  );
}

const percent = (share: number | undefined) => (share === undefined ? "–" : `${(100 * share).toFixed(1)} %`);

/** What the mean is aimed at where no number is given, with steps of brightness. */
const ofScene = (stops: number) =>
  stops === 0 ? ", as the scene's colours" : `, ${stops > 0 ? "brighter" : "darker"} than the scene's colours`;

export function Targets() {
  const canvas = useRef<HTMLCanvasElement>(null);
  const image = pictures.main.value?.image;
  const scheme = dark.value;
  useEffect(() => {
    if (canvas.current && image) plot(canvas.current, image);
  }, [image, scheme]);
  const targets = doc.value?.targets;
  const measured = judged.main.value?.measured;
  if (!targets) return null;
  const weights = doc.value?.weights ?? {};
  const mean = targets.mean ?? measured?.mean_target ?? 0.5;
  const aimed = measured?.mean_target ?? mean;
  return (
    <div class="targets">
      <div class="histogram">
        <canvas ref={canvas} width={320} height={72} role="img" aria-label="Histogram of the object's brightness" />
        {measured && <i class="measured" style={{ left: `${100 * measured.mean}%` }} />}
        {(weights.spread ?? 0) > 0 && (
          <>
            <i class="band" style={{ left: `${100 * Math.max(0, aimed - targets.spread)}%`, right: `${100 * Math.max(0, 1 - aimed - targets.spread)}%` }} />
            <Mark
              label="Target for the spread of brightness"
              class="spread"
              at={aimed + targets.spread}
              value={targets.spread}
              most={MOST_SPREAD}
              of={(place) => Math.abs(place - aimed)}
              set={(spread) => aim({ spread })}
            />
          </>
        )}
        <Mark label="Target for the mean brightness" class="mean" at={aimed} value={mean} most={1} of={(place) => place} set={(value) => aim({ mean: value, stops: 0 })} />
      </div>
      <p class="note">
        mean <b>{measured?.mean.toFixed(2) ?? "–"}</b>, aimed at <b>{aimed.toFixed(2)}</b>
        {targets.mean === null ? ofScene(targets.stops) : " "}
        {targets.mean !== null && (
          <button
            type="button"
            class="link"
            onClick={() => {
              aim({ mean: null });
              commit("Target from the scene");
            }}
          >
            Take from the scene
          </button>
        )}
      </p>
      <p class="note">burnt out {percent(measured?.burnt)}, unlit {percent(measured?.unlit)}</p>
    </div>
  );
}
