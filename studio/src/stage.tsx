// The picture, large: alone, under a wiper or beside what it is compared with.
import { signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { compared, manner, wiper } from "./comparing";
import { doc, opened } from "./document";
import { judged, pictures, rate, shownWidth, standing } from "./drawing";
import { clamp } from "./math";
import { Canvas, Picture } from "./picture";
import { StageBar, ViewBar } from "./stage_bar";

const GAP = 12;

/** The room that the pictures have, CSS pixels. */
const room = signal<[number, number]>([0, 0]);

/** The largest size of the pictures in the room, and whether two of them stand side by side. */
function fit([width, height]: [number, number], shape: number, count: number) {
  const alone = Math.min(width, height * shape);
  if (count === 1) return { width: alone, row: true };
  const across = Math.min((width - GAP) / 2, height * shape);
  const down = Math.min(width, ((height - GAP) / 2) * shape);
  return across >= down ? { width: across, row: true } : { width: down, row: false };
}

/** The name for people of what the picture is compared with. */
export function comparedTitle(): string {
  if (compared.value === "kept") return "Set aside";
  return opened.value?.presets.find(({ name }) => name === compared.value)?.title ?? "";
}

function Wiper() {
  const at = wiper.value;
  const onKeyDown = (event: KeyboardEvent) => {
    const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!way) return;
    event.preventDefault();
    event.stopPropagation();
    wiper.value = clamp(at + way * (event.shiftKey ? 0.005 : 0.025), 0, 1);
  };
  const onPointerDown = (event: PointerEvent & { currentTarget: HTMLElement }) => {
    event.stopPropagation();
    const handle = event.currentTarget;
    const box = handle.parentElement!.getBoundingClientRect();
    handle.setPointerCapture(event.pointerId);
    handle.onpointermove = (move) => {
      move.stopPropagation();
      wiper.value = clamp((move.clientX - box.left) / box.width, 0, 1);
    };
    handle.onpointerup = handle.onpointercancel = () => {
      handle.onpointermove = handle.onpointerup = handle.onpointercancel = null;
    };
  };
  return (
    <div
      class="wiper"
      role="slider"
      tabIndex={0}
      aria-label={`Wiper between ${comparedTitle()} on the left and the lights on the right`}
      aria-valuemin={0}
      aria-valuemax={100}
      aria-valuenow={Math.round(100 * at)}
      style={{ left: `${100 * at}%` }}
      onKeyDown={onKeyDown}
      onPointerDown={onPointerDown}
      onDblClick={(event) => event.stopPropagation()}
    />
  );
}

function Frames() {
  const size = doc.value?.size;
  if (!size) return null;
  const other = compared.value !== null;
  const beside = other && manner.value === "beside";
  const shape = size[0] / size[1];
  const { width, row } = fit(room.value, shape, beside ? 2 : 1);
  const box = { width: `${Math.floor(width)}px`, height: `${Math.floor(width / shape)}px` };
  const score = judged.main.value?.score.toFixed(4);
  return (
    <div class={row ? "frames" : "frames down"}>
      {beside && (
        <figure class="frame" style={box}>
          <div class="picture still"><Canvas shown={pictures.other} /></div>
          <figcaption>{comparedTitle()} <span class="number">{judged.other.value?.score.toFixed(4)}</span></figcaption>
        </figure>
      )}
      <figure class="frame" style={box}>
        <Picture label={`The model under the lights, F ${score ?? "unknown"}`}>
          <Canvas shown={pictures.main} />
          {other && !beside && (
            <>
              <div class="under" style={{ "clip-path": `inset(0 ${100 - 100 * wiper.value}% 0 0)` }}><Canvas shown={pictures.other} /></div>
              <Wiper />
            </>
          )}
        </Picture>
        {other && !beside && <figcaption class="left">{comparedTitle()} <span class="number">{judged.other.value?.score.toFixed(4)}</span></figcaption>}
        {other && <figcaption class="right">These lights <span class="number">{score}</span></figcaption>}
      </figure>
    </div>
  );
}

const duration = (milliseconds: number) =>
  milliseconds < 1000 ? `${milliseconds.toFixed(1)} ms` : `${(milliseconds / 1000).toFixed(1)} s`;

function Status() {
  const shown = pictures.main.value;
  const quality = ["coarse", "full", "final, anti-aliased"][shown?.quality ?? 0];
  const device = opened.value?.device.name ?? "";
  return (
    <div class="status">
      <span class="brief">F {judged.main.value?.score.toFixed(4) ?? "–"}</span>
      {shown && <span>{shown.image.width} × {shown.image.height}, {quality}, {duration(shown.milliseconds)}</span>}
      {rate.value > 4 && shown?.quality !== 2 && <span>{rate.value} pictures a second</span>}
      <span class="device">{device}</span>
      <ViewBar />
    </div>
  );
}

export function Stage() {
  const element = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const observer = new ResizeObserver(([entry]) => {
      const { width, height } = entry!.contentRect;
      room.value = [width, height];
      const shape = doc.value ? doc.value.size[0] / doc.value.size[1] : 1;
      shownWidth.value = Math.round(Math.min(width, height * shape) * devicePixelRatio);
    });
    observer.observe(element.current!);
    return () => observer.disconnect();
  }, []);
  return (
    <section class="stage" aria-label="Picture" aria-busy={!standing.value}>
      <StageBar />
      <div class="room" ref={element}><Frames /></div>
      <Status />
    </section>
  );
}
