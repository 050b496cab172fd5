//! The socket of a page: requests in, answers and pictures out.

use super::answers::Answer;
use super::hall::Studio;
use super::mailbox::Mailbox;
use super::messages::Request;
use super::worker::{Frame, Outbox, Worker};
use axum::body::Bytes;
use axum::extract::State;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::response::Response;
use serde_json::Value;
use std::sync::Arc;
use tokio::sync::mpsc;

/// Most bytes of a request.
const MOST: usize = 1 << 20;

/// Answers that wait until the page takes them; then the page's thread waits too.
const WAITING: usize = 8;

/// Opens a socket.
pub async fn open(State(studio): State<Arc<Studio>>, upgrade: WebSocketUpgrade) -> Response {
    upgrade.max_message_size(MOST).max_frame_size(MOST).on_upgrade(|socket| serve(studio, socket))
}

/// Serves a page until it goes.
async fn serve(studio: Arc<Studio>, mut socket: WebSocket) {
    let mailbox = Arc::new(Mailbox::default());
    let (outbox, mut answers) = mpsc::channel(WAITING);
    let own = Arc::clone(&mailbox);
    let faults = outbox.clone();
    let thread = std::thread::Builder::new().name("klieg studio page".into());
    if thread.spawn(move || Worker::run(studio, own, outbox)).is_err() {
        return;
    }
    loop {
        tokio::select! {
            message = socket.recv() => match message {
                Some(Ok(Message::Text(text))) => take(&text, &mailbox, &faults),
                Some(Ok(Message::Binary(_))) => refuse(&faults, None, "requests are texts".into()),
                Some(Ok(Message::Ping(_) | Message::Pong(_))) => {}
                Some(Ok(Message::Close(_)) | Err(_)) | None => break,
            },
            answer = answers.recv() => {
                let Some(message) = answer.and_then(message) else { break };
                if socket.send(message).await.is_err() {
                    break;
                }
            }
        }
    }
    mailbox.close();
}

/// Passes a request on.
fn take(text: &str, mailbox: &Mailbox, faults: &Outbox) {
    match serde_json::from_str::<Request>(text) {
        Ok(request) => mailbox.ask(request),
        Err(error) => {
            let value: Value = serde_json::from_str(text).unwrap_or_default();
            let id = value["id"].as_u64().and_then(|id| u32::try_from(id).ok());
            refuse(faults, id, format!("the request cannot be read: {error}"));
        }
    }
}

/// Tells of a fault, unless so many answers wait that the page can not have sent what it is about.
fn refuse(faults: &Outbox, id: Option<u32>, message: String) {
    let _ = faults.try_send(Frame::Answer(Box::new(Answer::Fault { id, message })));
}

fn message(frame: Frame) -> Option<Message> {
    match frame {
        Frame::Answer(answer) => Some(Message::Text(serde_json::to_string(&answer).ok()?.into())),
        Frame::Picture(bytes) => Some(Message::Binary(Bytes::from(bytes))),
    }
}
