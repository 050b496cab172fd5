// The beginning.
import { render } from "preact";
import { App } from "./app";
import { beginComparing } from "./comparing";
import { beginDrawing, drawFailed, drawn } from "./drawing";
import { beginGallery, pictured, seekFailed } from "./gallery";
import { token } from "./http";
import { beginKeys } from "./keys";
import { beginMapping, mapFailed } from "./landscape";
import { complain } from "./notices";
import { beginDropping } from "./opening";
import { beginRemembering, connected } from "./scene";
import { beginSearching } from "./searching";
import { connect, connection } from "./socket";
import { beginTheme } from "./theme";

beginTheme();
beginDrawing();
beginMapping();
beginSearching();
beginGallery();
beginComparing();
beginRemembering();
beginKeys();
beginDropping();
render(<App />, document.getElementById("klieg")!);

if (token === "") connection.value = "refused";
else
  connect(
    () => void connected(),
    (picture) => (picture.thumbnail ? pictured(picture) : drawn(picture)),
    (id, message) => {
      drawFailed(id);
      mapFailed(id);
      seekFailed(id);
      complain(message);
    },
  );
