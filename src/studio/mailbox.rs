//! Where requests wait: a newer one takes the place of an older one of its type, so that they never queue.

use super::messages::Request;
use super::worker::Event;
use std::collections::VecDeque;
use std::mem::discriminant;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// What comes next.
pub enum Next {
    /// Something is asked for.
    Request(Box<Request>),
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
    requests: VecDeque<Box<Request>>,
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
        match requests.iter_mut().find(|older| discriminant(&***older) == kind) {
            Some(older) => **older = request,
            None => requests.push_back(Box::new(request)),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studio::messages::{Open, Preset};

    fn open(id: u32) -> Request {
        Request::Open(Open { id, scene: None })
    }

    fn preset(id: u32) -> Request {
        Request::Preset(Preset { id, name: String::new() })
    }

    fn id(next: Next) -> Option<u32> {
        match next {
            Next::Request(request) => Some(request.id()),
            _ => None,
        }
    }

    #[test]
    fn the_newest_of_each_type_stands_where_the_oldest_stood() {
        let mailbox = Mailbox::default();
        [open(1), preset(2), open(3), open(4)].into_iter().for_each(|request| mailbox.ask(request));
        assert_eq!(id(mailbox.next(true)), Some(4));
        assert_eq!(id(mailbox.next(true)), Some(2));
        assert!(matches!(mailbox.next(false), Next::Nothing));
    }

    #[test]
    fn whoever_waits_is_woken_and_a_closed_one_gives_nothing_more() {
        let mailbox = Mailbox::default();
        std::thread::scope(|scope| {
            let waiting = scope.spawn(|| id(mailbox.next(true)));
            mailbox.ask(open(7));
            assert_eq!(waiting.join().unwrap(), Some(7));
            let waiting = scope.spawn(|| matches!(mailbox.next(true), Next::Closed));
            mailbox.close();
            assert!(waiting.join().unwrap());
        });
        mailbox.ask(open(8));
        assert!(matches!(mailbox.next(true), Next::Closed));
    }
}
