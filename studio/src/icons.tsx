// The page's icons: strokes on a grid of 20.

const PATHS = {
  add: "M10 4v12M4 10h12",
  close: "M5 5l10 10M15 5L5 15",
  undo: "M7 4L3 8l4 4M3 8h8a5 5 0 0 1 0 10H8",
  redo: "M13 4l4 4-4 4M17 8H9a5 5 0 0 0 0 10h3",
  open: "M3 15V5h5l2 2h7v8zM3 10h14",
  save: "M10 3v9M6 9l4 4 4-4M4 16h12",
  play: "M6 4l10 6-10 6z",
  pause: "M7 4v12M13 4v12",
  stop: "M5 5h10v10H5z",
  step: "M5 4l7 6-7 6zM15 4v12",
  lock: "M6 9V7a4 4 0 0 1 8 0v2M5 9h10v7H5z",
  unlock: "M6 9V6a4 4 0 0 1 7.6-1.6M5 9h10v7H5z",
  orbit: "M10 3a7 7 0 1 0 7 7M3 10c0 2 3 3.4 7 3.4s7-1.400 7-3.400M14 4l3-1M17 3l1 3",
  highlight: "M10 3a7 7 0 1 0 0 14 7 7 0 0 0 0-14zM8 6.200a1.600 1.600 0 1 0 .01 0",
  shading: "M10 3a7 7 0 1 0 0 14 7 7 0 0 0 0-14zM10 3v14M10 6h5M10 9h7M10 12h6.500M10 15h4.500",
  rim: "M10 3a7 7 0 1 0 0 14 7 7 0 0 0 0-14zM12.500 4.500a8 8 0 0 1 0 11",
  home: "M3 10l7-6 7 6M5 9v7h10V9",
  theme: "M10 3a7 7 0 1 0 0 14zM10 3a7 7 0 0 1 0 14",
  help: "M7.500 7.500a2.500 2.500 0 1 1 3.500 2.300c-.7.3-1 .8-1 1.700M10 14.500v.01",
  wiper: "M3 4h14v12H3zM10 4v12",
  beside: "M3 5h6v10H3zM11 5h6v10h-6z",
  keep: "M6 3h8v14l-4-3-4 3z",
  follow: "M3 7h8v6H3zM11 9l4-2v6l-4-2M17 4v12",
} as const;

export type IconName = keyof typeof PATHS;

export const Icon = ({ name }: { name: IconName }) => (
  <svg class="icon" viewBox="0 0 20 20" aria-hidden="true">
    <path d={PATHS[name]} />
  </svg>
);

type ButtonProps = {
  icon: IconName;
  label: string;
  /** Keys that do the same, for the tooltip. */
  keys?: string;
  text?: string;
  pressed?: boolean;
  disabled?: boolean;
  class?: string;
  onClick: () => void;
};

/** A button with an icon, whose name is a tooltip as well. */
export const IconButton = ({ icon, label, keys, text, pressed, disabled, onClick, ...more }: ButtonProps) => (
  <button
    type="button"
    class={`button ${text ? "" : "square"} ${more.class ?? ""}`}
    title={keys ? `${label} (${keys})` : label}
    aria-label={label}
    aria-pressed={pressed}
    disabled={disabled}
    onClick={onClick}
  >
    <Icon name={icon} />
    {text && <span>{text}</span>}
  </button>
);
