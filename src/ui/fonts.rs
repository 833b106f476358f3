//! Text in scripts that the built-in font lacks: by fonts of the system, looked for once one is needed. What none
//! of them can draw is noted, so that boxes in place of names are explained.
//!
//! egui shapes text, so Arabic letters join, but it lays lines out from left to right only.

use super::banners::Banner;
use super::panels::Model;
use egui::{FallbackRequest, FontInsert, FontProvider, GlyphRasterizer};
use egui_system_font_provider::SystemFontProvider;
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};

/// Lets text that the built-in fonts cannot draw be drawn with fonts of the system.
pub(super) fn use_those_of_the_system(ctx: &egui::Context) {
    ctx.add_font_provider(Arc::new(OnDemand::new(SystemFontProvider::new)));
}

/// A source of fonts that is opened when the first is asked for, and given up if it fails.
struct OnDemand<P, F>(Mutex<Source<P>>, F);

enum Source<P> {
    Unopened,
    Open(P),
    Failed,
}

impl<P, F> OnDemand<P, F> {
    fn new(open: F) -> Self {
        Self(Mutex::new(Source::Unopened), open)
    }
}

impl<P: FontProvider, F: Fn() -> P + Send + Sync> FontProvider for OnDemand<P, F> {
    fn font_for(&self, request: &FallbackRequest<'_>) -> Option<FontInsert> {
        let mut source = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // On a system without any font the search ends in a panic; boxes are better than no window.
        let found = catch_unwind(AssertUnwindSafe(|| {
            if matches!(*source, Source::Unopened) {
                *source = Source::Open((self.1)());
            }
            match &*source {
                Source::Open(provider) => provider.font_for(request),
                Source::Unopened | Source::Failed => None,
            }
        }));
        found.unwrap_or_else(|_| {
            *source = Source::Failed;
            None
        })
    }
}

/// Scripts by their code points, with the name of the script and a free font that has it.
const SCRIPTS: [(std::ops::RangeInclusive<u32>, &str, &str); 11] = [
    (0x0590..=0x05FF, "Hebrew", "Noto Sans Hebrew"),
    (0x0600..=0x08FF, "Arabic", "Noto Sans Arabic"),
    (0x0900..=0x097F, "Devanagari", "Noto Sans Devanagari"),
    (0x0E00..=0x0E7F, "Thai", "Noto Sans Thai"),
    (0x1100..=0x11FF, "Korean", "Noto Sans CJK"),
    (0x2E80..=0x2FDF, "Chinese", "Noto Sans CJK"),
    (0x3040..=0x30FF, "Japanese", "Noto Sans CJK"),
    (0x3400..=0x9FFF, "Chinese", "Noto Sans CJK"),
    (0xAC00..=0xD7AF, "Korean", "Noto Sans CJK"),
    (0xF900..=0xFAFF, "Chinese", "Noto Sans CJK"),
    (0x20000..=0x323AF, "Chinese", "Noto Sans CJK"),
];

/// Characters that were to be shown and that no font has.
#[derive(Clone, Default)]
pub(super) struct Unreadable(Arc<Mutex<BTreeSet<char>>>);

impl Unreadable {
    /// Takes note of them from now on.
    pub(super) fn of(ctx: &egui::Context) -> Self {
        let unreadable = Self::default();
        let noted = unreadable.clone();
        // Asked last, once the built-in fonts and those of the system have failed.
        ctx.add_glyph_rasterizer(GlyphRasterizer::new("lumenwalk::unreadable", move |request| {
            noted.note(request.cluster);
            None
        }));
        unreadable
    }

    fn note(&self, cluster: &str) {
        let readable = |c: &char| c.is_control() || c.is_whitespace();
        if let Some(character) = cluster.chars().next().filter(|c| !readable(c)) {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(character);
        }
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// Why there are boxes in place of letters, where there are any.
    fn sentence(&self) -> Option<String> {
        let characters = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let first = *characters.first()?;
        let script_of = |c: char| SCRIPTS.iter().find(|(range, ..)| range.contains(&u32::from(c)));
        let mut scripts: Vec<&str> = Vec::new();
        let mut fonts: Vec<&str> = Vec::new();
        for (_, script, font) in characters.iter().filter_map(|&c| script_of(c)) {
            if !scripts.contains(script) {
                scripts.push(script);
            }
            if !fonts.contains(font) {
                fonts.push(font);
            }
        }
        Some(if scripts.is_empty() {
            format!(
                "No font on this computer has the character U+{:04X}: names that contain it show a box.",
                u32::from(first)
            )
        } else {
            format!(
                "No font on this computer has {} characters: names in that script show boxes. Install {} and start \
                 again to read them; files and the solution are not affected.",
                scripts.join(" and "),
                fonts.join(" and ")
            )
        })
    }
}

/// Says why names cannot be read.
pub(super) fn banner(model: &Model<'_>) -> Option<Banner> {
    let text = model.unreadable.sentence()?;
    Some(Banner { key: "unreadable", is_warning: false, text, actions: Vec::new() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    /// A provider that tells how often it is opened and asked.
    struct Counted<'a> {
        asked: &'a AtomicU32,
        fails: bool,
    }

    impl FontProvider for Counted<'_> {
        fn font_for(&self, _: &FallbackRequest<'_>) -> Option<FontInsert> {
            self.asked.fetch_add(1, Ordering::Relaxed);
            assert!(!self.fails, "no fonts here");
            None
        }
    }

    #[test]
    fn fonts_are_looked_for_when_one_is_needed_and_not_again_after_a_failure() {
        let family = egui::FontFamily::Proportional;
        let request = FallbackRequest { cluster: "卧", family: &family };
        for (fails, expected) in [(false, 3), (true, 1)] {
            let (opened, asked) = (AtomicU32::new(0), AtomicU32::new(0));
            let provider = OnDemand::new(|| {
                opened.fetch_add(1, Ordering::Relaxed);
                Counted { asked: &asked, fails }
            });
            assert_eq!(opened.load(Ordering::Relaxed), 0);
            for _ in 0..3 {
                assert!(provider.font_for(&request).is_none());
            }
            assert_eq!((opened.load(Ordering::Relaxed), asked.load(Ordering::Relaxed)), (1, expected));
        }
    }

    #[test]
    fn what_cannot_be_read_is_named_by_its_script() {
        let unreadable = Unreadable::default();
        assert_eq!(unreadable.sentence(), None);
        unreadable.note("\u{263A}");
        assert!(unreadable.sentence().is_some_and(|text| text.contains("U+263A")));
        for cluster in ["卧", "室", "ضوء", " ", "\t"] {
            unreadable.note(cluster);
        }
        let text = unreadable.sentence().unwrap();
        assert!(text.contains("Arabic and Chinese") && text.contains("Noto Sans CJK"), "{text}");
        assert_eq!(unreadable.count(), 4);
    }
}
