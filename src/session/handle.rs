//! What the rest of the program holds of the worker: requests in, snapshots out.

use super::snapshot::Snapshot;
use super::threads;
use super::wanted::{Edits, Wanted};
use super::worker::Worker;
use crate::direct::Focus;
use crate::scene::{DaylightChoice, PlacedLamp, Scene, SceneSource};
use crate::solve::{SolveSettings, Stage};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// A changed reflectance, by index into the scene's materials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialEdit {
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// New reflectance per band, 0 to `MAX_REFLECTANCE`; with a texture, its factor.
    pub reflectance: [f64; 3],
}

/// What both threads see.
pub(super) struct Shared {
    pub(super) wanted: Mutex<Wanted>,
    pub(super) news_for_worker: Condvar,
    /// Set with every request: ends what runs.
    pub(super) cancel: AtomicBool,
    /// Set with every request but for another sky: ends even direct light of a sky that is out of date.
    pub(super) cancel_direct: AtomicBool,
    pub(super) paused: AtomicBool,
    /// The user ended the solve; cleared by the next request.
    pub(super) stopped: AtomicBool,
    pub(super) quit: AtomicBool,
    pub(super) latest: Mutex<Arc<Snapshot>>,
    /// Light that has settled is to become finer while nothing else is asked for.
    pub(super) leisure: AtomicBool,
    /// Who looks at it.
    pub(super) focus: Mutex<Option<Focus>>,
}

/// Neither lock is held while anything can panic, so a poisoned one still holds a whole value.
pub(super) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A handle to the worker thread. Dropping it stops and joins the thread.
pub struct Session {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Session {
    /// Starts the thread, and threads of its own to compute with. `on_news` is called after each
    /// published snapshot, from one of them.
    ///
    /// # Errors
    /// The system gives no threads.
    pub fn spawn(on_news: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let shared = Arc::new(Shared {
            wanted: Mutex::default(),
            news_for_worker: Condvar::new(),
            cancel: AtomicBool::new(false),
            cancel_direct: AtomicBool::new(false),
            paused: AtomicBool::new(false),
            stopped: AtomicBool::new(false),
            quit: AtomicBool::new(false),
            latest: Mutex::default(),
            leisure: AtomicBool::new(false),
            focus: Mutex::default(),
        });
        let pool = threads::solving().map_err(std::io::Error::other)?;
        let thread = std::thread::Builder::new().name("radiosity worker".to_owned()).spawn({
            let shared = shared.clone();
            move || {
                threads::stand_back();
                Worker::new(shared, &on_news, &pool).run();
            }
        })?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// The newest snapshot: one short lock and one clone of an `Arc`.
    pub fn latest(&self) -> Arc<Snapshot> {
        locked(&self.shared.latest).clone()
    }

    /// Opens a scene and solves it; replaces whatever runs. The present scene stays if it fails.
    pub fn open(&self, source: SceneSource) {
        self.request(|wanted| wanted.open(source));
    }

    /// The same with settings of its own. If it fails, those of the present scene stay in force.
    pub fn open_with(&self, source: SceneSource, settings: SolveSettings) {
        self.request(|wanted| wanted.open_with(source, settings));
    }

    /// Solves the present scene again with these settings, reusing what they leave unchanged.
    pub fn set_settings(&self, settings: SolveSettings) {
        self.request(|wanted| wanted.settings = settings);
    }

    /// The settings asked for last, which may not be in force yet; once some are refused, those in force.
    pub fn settings(&self) -> SolveSettings {
        locked(&self.shared.wanted).settings.clone()
    }

    /// Solves again over the stored rows with these reflectances of `scene`, all that differ from its own.
    /// They hold for as long as that scene is the present one, and for no other.
    pub fn set_materials(&self, scene: &Arc<Scene>, materials: Vec<MaterialEdit>) {
        self.request(|wanted| wanted.edits = Edits::new(scene, materials));
    }

    /// Places these lamps in the scene as it was `read`, instead of those that its file places, and solves it.
    /// They hold for as long as that reading is the present one.
    pub fn set_lamps(&self, read: &Arc<Scene>, lamps: Vec<PlacedLamp>) {
        self.request(|wanted| wanted.lamps = Some((Arc::downgrade(read), lamps)));
    }

    /// Puts the scene as it was `read` under this sky, instead of that of its file, or under none. Where there was a sky
    /// before, mesh, rows and transport stay: direct light comes at once, what surfaces pass on a moment later. Newer
    /// wishes win; while they come quickly, each is still answered with its direct light.
    pub fn set_daylight(&self, read: &Arc<Scene>, choice: Option<DaylightChoice>) {
        let mut wanted = locked(&self.shared.wanted);
        wanted.daylight = Some((Arc::downgrade(read), choice));
        self.announce(&mut wanted);
    }

    /// Whether light that has settled becomes finer, step by step, while nothing else is asked for: shadows first,
    /// where somebody looks. Off at first.
    pub fn refine_at_leisure(&self, on: bool) {
        if self.shared.leisure.swap(on, Ordering::AcqRel) != on {
            self.wake();
        }
    }

    /// Tells where somebody looks; the next refinement heeds it.
    pub fn look_from(&self, focus: Option<Focus>) {
        *locked(&self.shared.focus) = focus;
    }

    /// Lets the solve rest where it is.
    pub fn pause(&self) {
        self.shared.paused.store(true, Ordering::Release);
        self.wake();
    }

    /// Goes on from there; after [`Self::stop`] it starts again, and in a scene without lamps it starts after all.
    pub fn resume(&self) {
        self.shared.paused.store(false, Ordering::Release);
        if self.latest().stage == Stage::Unlit {
            self.request(|wanted| wanted.unlit = true);
        } else if self.shared.stopped.load(Ordering::Acquire) {
            self.request(|_| {});
        } else {
            self.wake();
        }
    }

    /// Ends the solve, and its rest; the picture so far stays.
    pub fn stop(&self) {
        let _held = locked(&self.shared.wanted);
        self.shared.paused.store(false, Ordering::Release);
        self.shared.stopped.store(true, Ordering::Release);
        self.shared.cancel_direct.store(true, Ordering::Release);
        self.shared.cancel.store(true, Ordering::Release);
        self.shared.news_for_worker.notify_all();
    }

    fn request(&self, change: impl FnOnce(&mut Wanted)) {
        let mut wanted = locked(&self.shared.wanted);
        change(&mut wanted);
        self.shared.cancel_direct.store(true, Ordering::Release);
        self.announce(&mut wanted);
    }

    fn announce(&self, wanted: &mut Wanted) {
        wanted.generation += 1;
        self.shared.stopped.store(false, Ordering::Release);
        self.shared.cancel.store(true, Ordering::Release);
        self.shared.news_for_worker.notify_all();
    }

    fn wake(&self) {
        let _held = locked(&self.shared.wanted);
        self.shared.news_for_worker.notify_all();
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.shared.quit.store(true, Ordering::Release);
        self.shared.cancel_direct.store(true, Ordering::Release);
        self.shared.cancel.store(true, Ordering::Release);
        self.wake();
        if let Some(thread) = self.thread.take() {
            thread.join().ok();
        }
    }
}
