//! Answers that take longer than a frame: one thread at a time, the newest question wins, and the
//! last answer stays until the next one is there.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// A question and its last answer.
pub(super) struct Background<K, T> {
    answered: Option<(K, Arc<T>)>,
    underway: Option<(K, Receiver<T>)>,
    /// A question whose thread ended without an answer: it is not asked again.
    failed: Option<K>,
}

impl<K, T> Default for Background<K, T> {
    fn default() -> Self {
        Self { answered: None, underway: None, failed: None }
    }
}

impl<K: PartialEq + Clone, T: Send + 'static> Background<K, T> {
    /// Asks `question` unless it is answered already. Where another one is underway it is asked
    /// afterwards: call this in every frame. `wake` is called once the answer is there.
    pub(super) fn ask(
        &mut self,
        question: &K,
        answer: impl FnOnce() -> T + Send + 'static,
        wake: impl FnOnce() + Send + 'static,
    ) {
        if !self.is_open(question) {
            return;
        }
        let (sender, receiver) = channel();
        let work = move || {
            // Nobody listens any more when the window has closed.
            sender.send(answer()).ok();
            wake();
        };
        if std::thread::Builder::new().name("answers".to_owned()).spawn(work).is_ok() {
            self.underway = Some((question.clone(), receiver));
        }
    }

    /// Whether asking would start a thread: it is not answered, and none is underway.
    pub(super) fn is_open(&self, question: &K) -> bool {
        let settled = self.answered.as_ref().is_some_and(|(key, _)| key == question);
        !settled && self.underway.is_none() && self.failed.as_ref() != Some(question)
    }

    /// Takes over an answer that has come. Returns whether one has.
    pub(super) fn listen(&mut self) -> bool {
        let Some((question, receiver)) = self.underway.take() else { return false };
        match receiver.try_recv() {
            Ok(answer) => {
                self.answered = Some((question, Arc::new(answer)));
                true
            }
            Err(TryRecvError::Empty) => {
                self.underway = Some((question, receiver));
                false
            }
            Err(TryRecvError::Disconnected) => {
                self.failed = Some(question);
                false
            }
        }
    }

    /// The last answer and its question, which may be an older one.
    pub(super) fn latest(&self) -> Option<(&K, &Arc<T>)> {
        self.answered.as_ref().map(|(key, answer)| (key, answer))
    }

    /// Forgets the last answer; one underway is dropped when it comes.
    pub(super) fn forget(&mut self) {
        (self.answered, self.underway) = (None, None);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn wait(background: &mut Background<u32, u32>) {
        while !background.listen() {
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn the_last_answer_stays_until_the_next_is_there() {
        let mut background = Background::default();
        background.ask(&3, || 30, || {});
        wait(&mut background);
        let (release, hold) = channel::<()>();
        background.ask(
            &4,
            move || {
                hold.recv().ok();
                40
            },
            || {},
        );
        background.ask(&5, || 50, || {});
        assert_eq!(background.latest().map(|(k, t)| (*k, **t)), Some((3, 30)));
        drop(release);
        wait(&mut background);
        assert_eq!(background.latest().map(|(k, t)| (*k, **t)), Some((4, 40)));
        background.ask(&5, || 50, || {});
        wait(&mut background);
        assert_eq!(background.latest().map(|(k, t)| (*k, **t)), Some((5, 50)));
    }

    #[test]
    fn a_question_that_cannot_be_answered_is_asked_once() {
        let mut background: Background<u32, u32> = Background::default();
        background.ask(&1, || panic!("no answer"), || {});
        while background.failed.is_none() {
            background.listen();
            std::thread::sleep(Duration::from_millis(1));
        }
        background.ask(&1, || 10, || {});
        assert!(background.underway.is_none() && background.latest().is_none());
    }
}
