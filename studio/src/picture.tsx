// A picture on the page: its canvas, and what pointer and keys do on it.
import type { ReadonlySignal } from "@preact/signals";
import { effect, signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useLayoutEffect, useRef } from "preact/hooks";
import { home, orbit, pan, zoom } from "./camera";
import { pointerMoved, type Shown } from "./drawing";
import { commit } from "./history";
import { clamp } from "./math";
import { lookAt, place, placed, tool, TOOLS, type Point } from "./placing";
import { interrupt } from "./searching";

/** Degrees that the picture's width is worth in a drag. */
const TURN = 220;
const KEY_TURN = { coarse: 5, fine: 1 };
const WHEEL = 0.0012;
/** Share of the picture that an arrow key moves the cross, and with Shift. */
const CROSS = { coarse: 0.02, fine: 0.004 };

/** The cross that places lights by keys; shown while the picture has the focus. */
const cross = signal<Point>([0.5, 0.5]);

const shareOf = (event: MouseEvent, box: DOMRect): Point => [
  (event.clientX - box.left) / box.width,
  (event.clientY - box.top) / box.height,
];

function placeAt(point: Point) {
  const what = tool.value;
  if (what === "orbit") return;
  interrupt();
  void place(point, what);
}

function settle() {
  const what = tool.value;
  if (what === "orbit") commit("View", "view");
  else void place(placed.value?.point ?? [0.5, 0.5], what, () => commit(`Place ${what}`));
}

/** Follows the pointers on the picture: one turns or places, two pan and zoom. */
class Gesture {
  private readonly pointers = new Map<number, { x: number; y: number }>();

  constructor(private readonly element: HTMLElement) {}

  down(event: PointerEvent) {
    if (event.button > 2) return;
    event.preventDefault();
    this.element.focus({ preventScroll: true });
    this.element.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    interrupt();
    if (tool.value !== "orbit" && event.button === 0) this.place(event);
  }

  move(event: PointerEvent) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const box = this.element.getBoundingClientRect();
    const [right, down] = [(event.clientX - before.x) / box.height, (event.clientY - before.y) / box.height];
    pointerMoved(event);
    if (this.pointers.size > 1) this.pinch(event, right, down);
    else if (tool.value !== "orbit" && event.buttons === 1) this.place(event);
    else if (event.shiftKey || event.buttons > 1) pan(right, -down);
    else orbit(-right * TURN, down * TURN);
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  }

  up(event: PointerEvent) {
    if (!this.pointers.delete(event.pointerId) || this.pointers.size > 0) return;
    settle();
  }

  private place(event: PointerEvent) {
    const point = shareOf(event, this.element.getBoundingClientRect());
    placed.value = { point, hit: true };
    pointerMoved(event);
    placeAt([clamp(point[0], 0, 1), clamp(point[1], 0, 1)]);
  }

  private pinch(event: PointerEvent, right: number, down: number) {
    const other = [...this.pointers].find(([id]) => id !== event.pointerId)?.[1];
    const before = this.pointers.get(event.pointerId);
    if (!other || !before) return;
    const was = Math.hypot(before.x - other.x, before.y - other.y);
    const is = Math.hypot(event.clientX - other.x, event.clientY - other.y);
    if (was > 0 && is > 0) zoom(was / is);
    pan(right / 2, -down / 2);
  }
}

const WAYS: Record<string, Point> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

function onKeyDown(event: KeyboardEvent) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const way = WAYS[event.key];
  const what = tool.value;
  if (way && what === "orbit") {
    const step = event.shiftKey ? KEY_TURN.fine : KEY_TURN.coarse;
    interrupt();
    orbit(way[0] * step, -way[1] * step);
    commit("View", "view");
  } else if (way) {
    const step = event.shiftKey ? CROSS.fine : CROSS.coarse;
    cross.value = [clamp(cross.value[0] + way[0] * step, 0, 1), clamp(cross.value[1] + way[1] * step, 0, 1)];
  } else if (event.key === "Enter" && what !== "orbit") {
    interrupt();
    void place(cross.value, what, () => commit(`Place ${what}`));
  } else if (["+", "=", "-"].includes(event.key)) {
    interrupt();
    zoom(event.key === "-" ? 1.1 : 1 / 1.1);
    commit("View", "view");
  } else if (event.key === "Home") {
    interrupt();
    void home().then(() => commit("View"));
  } else return;
  event.preventDefault();
}

/** The canvas of what came last, which is put there as it comes: pictures do not wait for the page. */
export function Canvas({ shown }: { shown: ReadonlySignal<Shown | null> }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  useLayoutEffect(
    () =>
      effect(() => {
        const element = canvas.current!;
        const { image, quality } = shown.value ?? { image: null, quality: "" };
        element.dataset.quality = String(quality);
        if (!image) return;
        if (element.width !== image.width || element.height !== image.height) {
          element.width = image.width;
          element.height = image.height;
        }
        element.getContext("2d")?.putImageData(image, 0, 0);
      }),
    [shown],
  );
  return <canvas ref={canvas} width={1} height={1} aria-hidden="true" />;
}

/** Where a click was, and the cross for the keys. */
function Marks() {
  const point = placed.value;
  if (tool.value === "orbit") return null;
  const at = ([x, y]: Point) => ({ left: `${100 * x}%`, top: `${100 * y}%` });
  return (
    <>
      {point && <i class={point.hit ? "ping" : "ping missed"} style={at(point.point)} />}
      <i class="cross" style={at(cross.value)} />
    </>
  );
}

/** The picture that can be turned, zoomed and clicked. `children` lie over it. */
export function Picture({ label, children }: { label: string; children: ComponentChildren }) {
  const element = useRef<HTMLDivElement>(null);
  const gesture = useRef<Gesture | null>(null);
  useEffect(() => {
    const target = element.current!;
    gesture.current = new Gesture(target);
    const onWheel = (event: WheelEvent) => {
      event.preventDefault();
      interrupt();
      zoom(Math.exp(event.deltaY * (event.deltaMode === 1 ? 20 : 1) * WHEEL));
      commit("View", "view");
    };
    target.addEventListener("wheel", onWheel, { passive: false });
    return () => target.removeEventListener("wheel", onWheel);
  }, []);
  const hint = TOOLS.find((other) => other.tool === tool.value)?.hint ?? "";
  const onDoubleClick = (event: MouseEvent & { currentTarget: HTMLElement }) => {
    if (tool.value !== "orbit") return;
    const point = shareOf(event, event.currentTarget.getBoundingClientRect());
    void lookAt(point).then((hit) => hit && commit("Turn about this point"));
  };
  return (
    <div
      ref={element}
      class={`picture tool-${tool.value}`}
      role="application"
      aria-roledescription="picture of the model"
      aria-label={label}
      aria-description={hint}
      tabIndex={0}
      onKeyDown={onKeyDown}
      onDblClick={onDoubleClick}
      onContextMenu={(event) => event.preventDefault()}
      onPointerDown={(event) => gesture.current?.down(event)}
      onPointerMove={(event) => gesture.current?.move(event)}
      onPointerUp={(event) => gesture.current?.up(event)}
      onPointerCancel={(event) => gesture.current?.up(event)}
    >
      {children}
      <Marks />
    </div>
  );
}
