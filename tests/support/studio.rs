//! A studio's server in a process of its own, and a page's socket to it.

use crate::common::Folder;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::Duration;
pub use tungstenite::Message;
use tungstenite::WebSocket;

/// How long an answer may take.
const PATIENCE: Duration = Duration::from_secs(120);

/// A running server; it ends with this.
pub struct Server {
    pub child: Child,
    pub host: String,
    pub token: String,
}

impl Server {
    /// `klieg studio` in this folder, at 64x48 on the native evaluator.
    pub fn start(place: &Folder, arguments: &[&str]) -> Self {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin("klieg"));
        command.arg("studio").args(arguments).args(["--no-open", "--device", "cpu"]);
        command.args(["--size", "64x48", "--generations", "12"]);
        std::fs::create_dir_all(place.path("tmp")).unwrap();
        command.env("TMPDIR", place.path("tmp"));
        command.current_dir(place.path("")).stdout(Stdio::piped()).stdin(Stdio::null());
        let mut child = command.spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix("studio: http://").expect("the page's address");
        let (host, token) = address.split_once("/?token=").expect("a token");
        assert_eq!(token.len(), 32, "128 bits");
        Self { host: host.into(), token: token.into(), child }
    }

    /// Sends a request with its head as it stands; gives status, head and body of the answer.
    pub fn raw(&self, head: &str, body: &[u8]) -> (u16, String, Vec<u8>) {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.write_all(head.as_bytes()).unwrap();
        // A server that refuses by the head alone may close before all of it has come.
        let _ = stream.write_all(body);
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n").expect("a head");
        let head = String::from_utf8(answer[..end].to_vec()).unwrap().to_lowercase();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        (status, head, answer[end + 4..].to_vec())
    }

    /// A request of the page's own.
    pub fn request(&self, method: &str, path: &str, body: &[u8]) -> (u16, String, Vec<u8>) {
        let (host, token, length) = (&self.host, &self.token, body.len());
        let head = format!(
            "{method} {path} HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nx-klieg-token: {token}\r\n\
             Content-Length: {length}\r\nConnection: close\r\n\r\n"
        );
        self.raw(&head, body)
    }

    /// Posts a scene; gives status and answer.
    pub fn post(&self, name: &str, bytes: &[u8]) -> (u16, Value) {
        let (status, _, body) = self.request("POST", &format!("/scene?name={name}"), bytes);
        (status, serde_json::from_slice(&body).unwrap())
    }

    /// A socket, opened with a token.
    pub fn connect(&self, token: &str) -> Result<Page, u16> {
        let stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let address = format!("ws://{}/socket?token={token}", self.host);
        match tungstenite::client(address, stream) {
            Ok((socket, _)) => Ok(Page { socket, id: 0 }),
            Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(answer))) => {
                Err(answer.status().as_u16())
            }
            Err(error) => panic!("{error}"),
        }
    }

    /// A page that has opened the scene of the command line, and what it was told.
    pub fn page(&self) -> (Page, Value) {
        let mut page = self.connect(&self.token).expect("a socket");
        let opened = page.ask("open", json!({}), "opened");
        (page, opened)
    }

    /// Resident memory of the process, KiB.
    pub fn memory(&self) -> u64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id())).unwrap();
        let line = status.lines().find(|line| line.starts_with("VmRSS")).unwrap();
        line.split_whitespace().nth(1).unwrap().parse().unwrap()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What a page is sent.
#[derive(Debug, Clone)]
pub enum Said {
    Answer(Value),
    Picture { id: u32, size: [u32; 2], kind: u32, index: u32, quality: u32, pixels: Vec<u8> },
}

impl Said {
    /// Type and id of an answer.
    fn is(&self, kind: &str, of: u32) -> bool {
        match self {
            Self::Answer(value) => value["type"] == kind && value["id"] == of,
            Self::Picture { id, .. } => kind == "picture" && *id == of,
        }
    }
}

/// A page's socket.
pub struct Page {
    pub socket: WebSocket<TcpStream>,
    pub id: u32,
}

impl Page {
    /// Sends a request and gives its number.
    pub fn send(&mut self, kind: &str, mut request: Value) -> u32 {
        self.id += 1;
        request["type"] = kind.into();
        request["id"] = self.id.into();
        self.socket.send(Message::text(request.to_string())).unwrap();
        self.id
    }

    /// What comes next.
    pub fn read(&mut self) -> Said {
        loop {
            match self.socket.read().expect("an answer in time") {
                Message::Text(text) => return Said::Answer(serde_json::from_str(&text).unwrap()),
                Message::Binary(bytes) => return picture(&bytes),
                _ => {}
            }
        }
    }

    /// The first answer of a type to a request; a fault of it ends the test.
    pub fn until(&mut self, kind: &str, id: u32) -> Value {
        loop {
            let said = self.read();
            assert!(kind == "fault" || !said.is("fault", id), "{said:?}");
            if let Said::Answer(value) = &said
                && said.is(kind, id)
            {
                return value.clone();
            }
        }
    }

    /// Asks, and waits for an answer of a type.
    pub fn ask(&mut self, kind: &str, request: Value, answer: &str) -> Value {
        let id = self.send(kind, request);
        self.until(answer, id)
    }

    /// All that comes for a draw, up to the picture of that quality and its judgement.
    pub fn drawn(&mut self, id: u32, quality: u32) -> Vec<Said> {
        let mut all = Vec::new();
        loop {
            let said = self.read();
            assert!(!said.is("fault", id), "{said:?}");
            let last = match &said {
                Said::Picture { id: of, quality: found, .. } => {
                    quality == 2 && *of == id && *found == 2
                }
                Said::Answer(value) => said.is("judged", id) && value["quality"] == quality,
            };
            all.push(said);
            if last {
                return all;
            }
        }
    }
}

fn picture(bytes: &[u8]) -> Said {
    let word = |at: usize| u32::from_le_bytes(bytes[4 * at..4 * at + 4].try_into().unwrap());
    assert_eq!(word(0), 0x4b4c_4753);
    let size = [word(2), word(3)];
    let pixels = bytes[32..].to_vec();
    assert_eq!(pixels.len(), 4 * (size[0] * size[1]) as usize);
    Said::Picture { id: word(1), size, kind: word(4), index: word(5), quality: word(6), pixels }
}

/// What a page shows that has just opened a scene.
pub fn look(opened: &Value) -> Value {
    let (scene, defaults) = (&opened["scene"], &opened["defaults"]);
    json!({
        "size": [64, 48],
        "camera": scene["camera"],
        "lights": defaults["lights"],
        "weights": defaults["weights"],
        "targets": defaults["targets"],
        "intent": defaults["intent"],
        "focus": defaults["focus"],
        "dim": defaults["dim"],
    })
}

/// The same with other fields.
pub fn with(value: &Value, more: Value) -> Value {
    let mut value = value.clone();
    more.as_object().unwrap().iter().for_each(|(key, field)| value[key] = field.clone());
    value
}
