use super::failure::Failure;
use super::picture::Studio;
use super::progress::ProgressLine;
use super::text;
use crate::display::Exposure;
use crate::export::atomic;
use crate::navigation::{FreeSpace, Tour, person_scale, walking_pace};
use crate::outputs::{StillKind, save_still};
use crate::scene::Scene;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Frames a second where nothing else is asked for.
pub(super) const DEFAULT_FPS: f64 = 30.0;

/// Seconds between two places at which the tour is metered.
const METER_EVERY: f64 = 0.25;
/// Seconds over which the exposure follows what is seen, before and after.
const ADAPTS_WITHIN: f64 = 1.5;

/// Where the frames of a tour go.
pub(super) struct FrameFolder {
    folder: PathBuf,
    tour: Tour,
    frames: usize,
    /// Sentences on where it goes straight through walls.
    barred: String,
}

impl FrameFolder {
    /// Plans the tour through the bookmarks of `scene` and makes sure that its frames can be written.
    ///
    /// # Errors
    /// Fewer than two bookmarks, a folder that cannot be made or written to, or one that holds frames
    /// of a longer tour: they would look like the end of this one.
    pub(super) fn ready(folder: &Path, scene: &Scene, fps: f64) -> Result<Self, Failure> {
        let extent = scene.extent();
        let (up, bounds) = (scene.up.vector(), extent.main);
        let height = bounds.size().dot(up).abs();
        let eyes: Vec<_> = scene.views.iter().map(|view| view.eye).collect();
        let space = FreeSpace::new(&scene.main_triangles(&extent), &eyes, up, person_scale(height));
        let pace = walking_pace(height, extent.scale);
        let tour = Tour::walk(&scene.views, up, pace, &space).ok_or_else(|| {
            Failure::input(format!(
                "a tour needs two bookmarks at least, and {} has {}",
                scene.name,
                scene.views.len()
            ))
        })?;
        let planned =
            Self { barred: barred(&tour, scene), folder: folder.to_owned(), frames: tour.frames(fps), tour };
        let refused = |error: std::io::Error| {
            let context = format!("cannot write frames into {}", folder.display());
            Failure::work(anyhow::Error::new(error).context(context))
        };
        fs::create_dir_all(folder).map_err(refused)?;
        for entry in fs::read_dir(folder).map_err(refused)? {
            let name = entry.map_err(refused)?.file_name();
            if number_of(&name.to_string_lossy()).is_some_and(|number| number > planned.frames) {
                return Err(Failure::input(format!(
                    "{} holds frames of a longer tour, such as {}; name another folder",
                    folder.display(),
                    name.display()
                )));
            }
        }
        atomic::probe(&planned.path(0))?;
        Ok(planned)
    }

    /// What was written, in a line.
    pub(super) fn told(&self) -> String {
        let (frames, seconds) = (text::count(self.frames, "frame"), text::seconds(self.tour.seconds()));
        format!("{}wrote {frames}, a tour of {seconds}, into {}\n", self.barred, self.folder.display())
    }

    fn path(&self, index: usize) -> PathBuf {
        self.folder.join(format!("frame-{:05}.png", index + 1))
    }

    /// Renders and writes all frames, in order, each whole.
    ///
    /// # Errors
    /// A refusal of the system to write.
    pub(super) fn write(&self, studio: &Studio<'_>, size: [u32; 2]) -> Result<(), Failure> {
        let (started, count) = (Instant::now(), self.frames);
        let exposures = self.exposures(studio, size);
        let mut line = ProgressLine::new();
        for index in 0..count {
            let seconds = self.tour.frame_time(index, count);
            let exposure = at(&exposures, seconds / self.tour.seconds());
            let still = studio.still(&self.tour.camera(seconds), size, exposure, |share| {
                line.tour(index, count, (index as f64 + share) / count as f64, started.elapsed());
            })?;
            save_still(&self.path(index), StillKind::Png, &still)?;
        }
        Ok(())
    }

    /// Exposure values along the tour, evenly spaced in time: metered, then smoothed, so that nothing
    /// flickers and a door is not passed blindly.
    fn exposures(&self, studio: &Studio<'_>, size: [u32; 2]) -> Vec<f64> {
        let steps = (self.tour.seconds() / METER_EVERY).ceil().max(1.0) as usize;
        let spacing = self.tour.seconds() / steps as f64;
        let metered: Vec<Option<f64>> = (0..=steps)
            .map(|k| studio.metered(&self.tour.camera(k as f64 * spacing), size).map(|e| e.ev100))
            .collect();
        smoothed(&metered, ADAPTS_WITHIN / spacing)
    }
}

/// A line for each bookmark from which no way leads to the next.
fn barred(tour: &Tour, scene: &Scene) -> String {
    let legs = tour.barred().iter().filter_map(|&k| scene.views.get(k).zip(scene.views.get(k + 1)));
    legs.map(|(from, to)| format!("no way leads from {} to {}: the tour goes straight\n", from.name, to.name))
        .collect()
}

/// The number of a frame by its file's name.
fn number_of(name: &str) -> Option<usize> {
    name.strip_prefix("frame-")?.strip_suffix(".png")?.parse().ok()
}

/// Weighted means over neighbours up to `reach` steps away, weights falling evenly; what could not be
/// measured takes no part.
fn smoothed(values: &[Option<f64>], reach: f64) -> Vec<f64> {
    let reach = reach.max(1.0);
    let usual = Exposure::default().ev100;
    let known = |k: usize| values.get(k).copied().flatten();
    (0..values.len())
        .map(|k| {
            let (mut sum, mut weights) = (0.0, 0.0);
            for j in k.saturating_sub(reach as usize)..=k + reach as usize {
                if let Some(value) = known(j) {
                    let weight = (1.0 - k.abs_diff(j) as f64 / (reach + 1.0)).max(0.0);
                    (sum, weights) = (sum + weight * value, weights + weight);
                }
            }
            let nearest = || {
                (0..values.len())
                    .filter(|&j| known(j).is_some())
                    .min_by_key(|&j| k.abs_diff(j))
                    .and_then(known)
            };
            if weights > 0.0 { sum / weights } else { nearest().unwrap_or(usual) }
        })
        .collect()
}

/// The exposure at a share of the tour, 0 to 1.
fn at(values: &[f64], share: f64) -> Exposure {
    let place = share.clamp(0.0, 1.0) * (values.len() - 1) as f64;
    let low = (place as usize).min(values.len() - 1);
    let high = (low + 1).min(values.len() - 1);
    Exposure { ev100: values[low] + (values[high] - values[low]) * (place - low as f64) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_of_the_light_becomes_a_ramp_and_gaps_are_bridged() {
        let values: Vec<Option<f64>> = (0..40).map(|k| Some(if k < 20 { 4.0 } else { 8.0 })).collect();
        let smooth = smoothed(&values, 6.0);
        assert!((smooth[0] - 4.0).abs() < 1e-12 && (smooth[39] - 8.0).abs() < 1e-12);
        let steepest = smooth.windows(2).map(|v| v[1] - v[0]).fold(0.0, f64::max);
        assert!(smooth.is_sorted() && steepest < 0.7, "{steepest}");
        assert_eq!(smoothed(&[None, None, Some(5.0), None], 1.0), [5.0; 4]);
        assert_eq!(smoothed(&[None, None], 1.0), [Exposure::default().ev100; 2]);
        assert!((at(&[4.0, 8.0], 0.25).ev100 - 5.0).abs() < 1e-12);
        assert_eq!(at(&[4.0], 1.0).ev100, 4.0);
    }

    #[test]
    fn frames_are_known_by_their_names() {
        assert_eq!(number_of("frame-00042.png"), Some(42));
        for other in ["frame-.png", "frame-00042.jpg", "picture.png", "frame-1x.png"] {
            assert_eq!(number_of(other), None, "{other}");
        }
    }
}
