// The page as a whole.
import { doc, scene } from "./document";
import { Dome } from "./dome";
import { HelpDialog, isHelping } from "./help";
import { canRedo, canUndo } from "./history";
import { Icon, IconButton } from "./icons";
import { goBack, goForward } from "./keys";
import { Lights } from "./lights";
import { busy, fault, spoken } from "./notices";
import { chooseFile, hovering } from "./opening";
import { isSaving, SaveDialog } from "./save";
import { Search } from "./search";
import { connection } from "./socket";
import { Stage } from "./stage";
import { Steps } from "./steps";
import { Strip } from "./strip";
import { Terms } from "./terms";
import { nextTheme, theme } from "./theme";
import { Wanted } from "./wanted";

const Bar = () => (
  <header class="bar">
    <h1><span class="mark-klieg" aria-hidden="true" />klieg studio</h1>
    <p class="scene-name">
      {scene.value ? (
        <>
          <b>{scene.value.name}</b>
          <span class="soft">{scene.value.triangles.toLocaleString("en")} triangles</span>
        </>
      ) : null}
    </p>
    <div class="row">
      <IconButton icon="undo" label="Undo" keys="Ctrl Z" disabled={!canUndo.value} onClick={goBack} />
      <IconButton icon="redo" label="Redo" keys="Ctrl Shift Z" disabled={!canRedo.value} onClick={goForward} />
    </div>
    <div class="row">
      <IconButton icon="open" label="Open a model or a session" keys="Ctrl O" text="Open" onClick={chooseFile} />
      <IconButton icon="save" label="Save" keys="Ctrl S" text="Save" class="primary" disabled={!doc.value} onClick={() => (isSaving.value = true)} />
    </div>
    <div class="row">
      <IconButton icon="theme" label={`Light or dark: ${theme.value === "auto" ? "as the system" : theme.value}`} class="quiet" onClick={nextTheme} />
      <IconButton icon="help" label="Keys and pointer" keys="?" class="quiet" onClick={() => (isHelping.value = true)} />
    </div>
  </header>
);

const Notices = () => (
  <div class="notices">
    {connection.value === "lost" && <p class="notice" role="status" data-lost>The server does not answer. Trying again each second; nothing is lost.</p>}
    {busy.value && <p class="notice" role="status">{busy.value}</p>}
    {fault.value && (
      <div class="notice fault" role="alert">
        <p>{fault.value}</p>
        <IconButton icon="close" label="Close this message" class="quiet" onClick={() => (fault.value = null)} />
      </div>
    )}
  </div>
);

const Empty = () => (
  <div class="empty">
    <Icon name="open" />
    <h2>Drop a model here</h2>
    <p>glTF, GLB, PLY, STL or OBJ; a lit model goes on with its lights, a session with all of its work.</p>
    <button type="button" class="button primary" onClick={chooseFile}>Open a file</button>
  </div>
);

const Refused = () => (
  <main class="refused">
    <h1>klieg studio</h1>
    <p>This address does not open the studio.</p>
    <p class="soft">Take the whole address that <code>klieg studio</code> has printed, with the token at its end. Each start has another one.</p>
    {doc.value && <p>The server has been started again. Where it has the same port, open its new address in this tab, and your work goes on.</p>}
  </main>
);

const Desk = () => (
  <main class="desk">
    <Stage />
    <div class="side left" role="group" aria-label="Lights">
      <Dome />
      <Lights />
    </div>
    <div class="side right" role="group" aria-label="Search and judgement">
      <Wanted />
      <Search />
      <Terms />
      <Steps />
    </div>
    <Strip />
  </main>
);

export function App() {
  if (connection.value === "refused") return <Refused />;
  return (
    <>
      <Bar />
      {doc.value ? <Desk /> : <main class="desk-empty">{connection.value === "open" && !busy.value ? <Empty /> : <p class="soft">Connecting…</p>}</main>}
      <Notices />
      <SaveDialog />
      <HelpDialog />
      {hovering.value && <div class="drop" aria-hidden="true">Drop to open</div>}
      <p class="hidden" role="status" aria-live="polite" data-spoken>{spoken.value}</p>
    </>
  );
}
