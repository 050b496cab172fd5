//! Where requests wait: a newer one takes the place of an older one of its type, so that they never queue.

use super::messages::Request;
use super::worker::Event;
use std::collections::VecDeque;
use std::mem::discriminant;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// What comes next.
pub enum Next {
    /// Something is asked for.
    Request(Request),
    /// Something that was begun is done.
    Event(Event),
    /// Nothing waits.
    Nothing,
    /// Nobody asks any more.
    Closed,
}

/// Requests and what has happened, for one thread.
#[derive(Default)]
pub struct Mailbox {
    waiting: Mutex<Waiting>,
    changed: Condvar,
}

#[derive(Default)]
struct Waiting {
    requests: VecDeque<Request>,
    events: VecDeque<Event>,
    closed: bool,
}

impl Mailbox {
    fn waiting(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts a request in.
    pub fn ask(&self, request: Request) {
        let requests = &mut self.waiting().requests;
        let kind = discriminant(&request);
        match requests.iter_mut().find(|older| discriminant(*older) == kind) {
            Some(older) => *older = request,
            None => requests.push_back(request),
        }
        self.changed.notify_all();
    }

    /// Tells of something that has happened.
    pub fn tell(&self, event: Event) {
        self.waiting().events.push_back(event);
        self.changed.notify_all();
    }

    /// Ends it: nothing that waits counts any more.
    pub fn close(&self) {
        self.waiting().closed = true;
        self.changed.notify_all();
    }

    /// What comes next; waits for it where `patient`.
    pub fn next(&self, patient: bool) -> Next {
        let mut waiting = self.waiting();
        loop {
            if waiting.closed {
                return Next::Closed;
            }
            if let Some(request) = waiting.requests.pop_front() {
                return Next::Request(request);
            }
            if let Some(event) = waiting.events.pop_front() {
                return Next::Event(event);
            }
            if !patient {
                return Next::Nothing;
            }
            waiting = self.changed.wait(waiting).unwrap_or_else(PoisonError::into_inner);
        }
    }
}
