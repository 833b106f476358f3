//! Undo and redo: states kept whole, one for each gesture.

/// States to go back and forward to. `K` says what an edit touches: edits of one thing in one
/// gesture (a dragged slider) make one step.
#[derive(Clone, Debug)]
pub(super) struct History<K, S> {
    past: Vec<S>,
    future: Vec<S>,
    open: Option<K>,
}

/// Steps that can be undone.
const DEPTH: usize = 200;

impl<K, S> Default for History<K, S> {
    fn default() -> Self {
        Self { past: Vec::new(), future: Vec::new(), open: None }
    }
}

impl<K: PartialEq, S> History<K, S> {
    /// Keeps `before`, the state that an edit of `key` is about to replace.
    pub(super) fn record(&mut self, key: K, before: S) {
        self.future.clear();
        if self.open.as_ref() == Some(&key) {
            return;
        }
        self.open = Some(key);
        if self.past.len() == DEPTH {
            self.past.remove(0);
        }
        self.past.push(before);
    }

    /// Ends the gesture: the next edit is a step of its own.
    pub(super) fn seal(&mut self) {
        self.open = None;
    }

    /// The state before the last edit; `now` can be redone.
    pub(super) fn undo(&mut self, now: S) -> Option<S> {
        self.seal();
        let before = self.past.pop()?;
        self.future.push(now);
        Some(before)
    }

    /// The state that was undone last.
    pub(super) fn redo(&mut self, now: S) -> Option<S> {
        self.seal();
        let after = self.future.pop()?;
        self.past.push(now);
        Some(after)
    }

    /// Whether there is a step to undo.
    pub(super) fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    /// Whether there is a step to redo.
    pub(super) fn can_redo(&self) -> bool {
        !self.future.is_empty()
    }

    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gesture_is_one_step_and_redo_returns_it() {
        let mut history = History::<char, i32>::default();
        let mut now = 0;
        for value in [1, 2, 3] {
            history.record('a', now);
            now = value;
        }
        history.seal();
        history.record('a', now);
        now = 10;
        history.record('b', now);
        now = 20;

        now = history.undo(now).expect("b");
        assert_eq!(now, 10);
        now = history.undo(now).expect("a again");
        assert_eq!(now, 3);
        now = history.undo(now).expect("the drag");
        assert_eq!(now, 0);
        assert!(!history.can_undo() && history.undo(now).is_none());
        now = history.redo(now).expect("the drag");
        assert_eq!(now, 3);
        history.record('c', now);
        assert!(!history.can_redo(), "a new edit ends what could be redone");
    }
}
