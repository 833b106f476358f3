//! Sessions that tests can wait for and hold.

use lumenwalk::mesh::PatchTarget;
use lumenwalk::scene::SceneSource;
use lumenwalk::session::{MaterialEdit, Session, Snapshot};
use lumenwalk::solve::{SolveSettings, Stage};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// A session that tells of every snapshot.
pub(crate) struct Watched {
    pub(crate) session: Session,
    pub(crate) news: Receiver<()>,
}

impl Watched {
    pub(crate) fn new() -> Self {
        let (tell, news) = channel();
        let session = Session::spawn(move || tell.send(()).unwrap_or(())).expect("a thread");
        Self { session, news }
    }

    /// With few patches, so that a solve takes milliseconds.
    pub(crate) fn coarse() -> Self {
        let watched = Self::new();
        watched.session.set_settings(coarse(300));
        watched
    }

    /// Waits for a snapshot; hours would pass before a hang were taken for a slow machine.
    #[track_caller]
    pub(crate) fn until(&self, what: &str, wanted: impl Fn(&Snapshot) -> bool) -> Arc<Snapshot> {
        loop {
            let latest = self.session.latest();
            if wanted(&latest) {
                return latest;
            }
            match self.news.recv_timeout(Duration::from_secs(300)) {
                Ok(()) => {}
                Err(RecvTimeoutError::Timeout) => panic!("no {what}; it stands at {:?}", latest.stage),
                Err(RecvTimeoutError::Disconnected) => panic!("the worker is gone"),
            }
        }
    }

    /// Waits until a request later than the snapshot `before` has converged.
    #[track_caller]
    pub(crate) fn converged(&self, before: &Snapshot) -> Arc<Snapshot> {
        self.until("convergence", |s| s.stage == Stage::Converged && s.last_change != before.last_change)
    }

    /// Gives a material of the present scene another reflectance.
    pub(crate) fn repaint(&self, material: u32, reflectance: [f64; 3]) {
        let scene = self.session.latest().scene().cloned().expect("a scene");
        self.session.set_materials(&scene, vec![MaterialEdit { material, reflectance }]);
    }

    pub(crate) fn open_builtin(&self, name: &str) -> Arc<Snapshot> {
        let before = self.session.latest();
        self.session.open(SceneSource::Builtin(name.to_owned()));
        self.converged(&before)
    }
}

/// A session whose worker can be held after a snapshot of some stage, until it is let go.
pub(crate) struct Held {
    // Dropped first: the worker must not wait for it while it is joined.
    pub(crate) let_go: Sender<()>,
    pub(crate) held: Receiver<()>,
    pub(crate) holds: Arc<AtomicBool>,
    pub(crate) watched: Watched,
}

impl Held {
    pub(crate) fn coarse() -> Self {
        let (tell, news) = channel();
        let (hold, held) = channel();
        let (let_go, gone) = channel();
        let gone = Mutex::new(gone);
        let holds = Arc::new(AtomicBool::new(false));
        let is_holding = Arc::clone(&holds);
        let session = Session::spawn(move || {
            tell.send(()).unwrap_or(());
            if is_holding.load(Ordering::SeqCst) && hold.send(()).is_ok() {
                gone.lock().unwrap().recv().unwrap_or(());
            }
        });
        let watched = Watched { session: session.expect("a thread"), news };
        watched.session.set_settings(coarse(300));
        Self { let_go, held, holds, watched }
    }

    /// Asks for something while the worker has nothing to do, and holds it at the next snapshot of this stage.
    pub(crate) fn hold_at(&self, stage: Stage, ask: impl FnOnce(&Session)) {
        self.holds.store(true, Ordering::SeqCst);
        ask(&self.watched.session);
        loop {
            self.held.recv_timeout(Duration::from_secs(300)).expect("news");
            if self.watched.session.latest().stage == stage {
                return;
            }
            self.let_go.send(()).expect("it waits");
        }
    }

    pub(crate) fn go_on(&self) {
        self.holds.store(false, Ordering::SeqCst);
        self.let_go.send(()).expect("it waits");
    }
}

pub(crate) fn coarse(patches: usize) -> SolveSettings {
    SolveSettings { patches: PatchTarget::Count(patches), resolution: Some(48), ..SolveSettings::default() }
}
