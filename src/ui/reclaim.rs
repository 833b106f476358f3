//! Large things that nobody needs any more are taken apart on a thread of their own: giving back the
//! memory of a matrix takes longer than a frame.

use std::any::Any;
use std::sync::mpsc::{Sender, channel};

/// The way to that thread, which ends when this is dropped.
pub(super) struct Reclaim(Option<Sender<Box<dyn Any + Send>>>);

impl Default for Reclaim {
    fn default() -> Self {
        let (sender, receiver) = channel::<Box<dyn Any + Send>>();
        let take_apart = move || receiver.into_iter().for_each(drop);
        let thread = std::thread::Builder::new().name("reclaim memory".to_owned()).spawn(take_apart);
        Self(thread.is_ok().then_some(sender))
    }
}

impl Reclaim {
    /// Takes `thing` apart there; here, where there is no such thread.
    pub(super) fn later(&self, thing: impl Send + 'static) {
        if let Some(sender) = &self.0 {
            sender.send(Box::new(thing)).ok();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread::ThreadId;
    use std::time::Duration;

    struct Tells(Sender<ThreadId>);

    impl Drop for Tells {
        fn drop(&mut self) {
            self.0.send(std::thread::current().id()).ok();
        }
    }

    #[test]
    fn things_are_dropped_on_another_thread() {
        let (sender, receiver) = channel();
        Reclaim::default().later(Tells(sender));
        let dropped_on = receiver.recv_timeout(Duration::from_secs(20)).expect("it is dropped");
        assert_ne!(dropped_on, std::thread::current().id());
    }
}
