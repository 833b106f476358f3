//! What is doubtful about a model: its kind, how much it matters, and where it is.

use super::types::{LengthUnit, UpAxis};
use glam::DVec3;
use std::fmt;

/// How much a [`Finding`] matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Severity {
    /// Good to know.
    Note,
    /// Repaired or doubtful; the result may differ from what was meant.
    Warning,
    /// Wrong; the part concerned was left out.
    Error,
}

/// What a [`Finding`] is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum FindingKind {
    /// Lines or values of a file that are not read.
    File,
    /// Faces, or corners of them, without any extent.
    Degenerate,
    /// Faces over the same corners.
    Duplicate,
    /// Faces that cover one another in one plane.
    Overlap,
    /// Faces that cut through each other.
    Interpenetration,
    /// Faces whose corners do not lie in one plane.
    NonPlanar,
    /// Outlines that touch or cross themselves.
    SelfCrossing,
    /// Vertex normals that are no use.
    Normals,
    /// Corners of one face in the middle of another's edge.
    TVertex,
    /// Edges that nearly meet.
    Crack,
    /// Edges with a face on one side only.
    OpenEdge,
    /// Edges that more than two faces share.
    SharedEdge,
    /// Neighbours that face opposite ways.
    Winding,
    /// Light that gets where it should not.
    Leak,
    /// Reflectances, emissions and images.
    Material,
    /// Lamps that are missing, dark or covered.
    Lamp,
    /// Parts that no light reaches.
    Unlit,
    /// A doubtful unit or size.
    Unit,
    /// A doubtful up axis.
    UpAxis,
    /// Parts far away from the rest.
    Stray,
    /// What was not looked for, because it would have taken too long.
    Unsearched,
}

impl FindingKind {
    /// What a list calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::File => "File",
            Self::Degenerate => "Degenerate faces",
            Self::Duplicate => "Duplicate faces",
            Self::Overlap => "Overlapping faces",
            Self::Interpenetration => "Interpenetrating faces",
            Self::NonPlanar => "Faces not planar",
            Self::SelfCrossing => "Crossed outlines",
            Self::Normals => "Vertex normals",
            Self::TVertex => "T-vertices",
            Self::Crack => "Cracks",
            Self::OpenEdge => "Open edges",
            Self::SharedEdge => "Edges of many faces",
            Self::Winding => "Inconsistent winding",
            Self::Leak => "Leaks",
            Self::Material => "Materials",
            Self::Lamp => "Lamps",
            Self::Unlit => "Unlit parts",
            Self::Unit => "Unit",
            Self::UpAxis => "Up axis",
            Self::Stray => "Stray parts",
            Self::Unsearched => "Not looked for",
        }
    }

    /// Whether a repaired copy of the model is free of it.
    pub fn is_mended(self) -> bool {
        matches!(
            self,
            Self::Degenerate
                | Self::Duplicate
                | Self::Interpenetration
                | Self::NonPlanar
                | Self::SelfCrossing
                | Self::TVertex
                | Self::Crack
                | Self::Winding
        )
    }
}

/// Most faces, edges, points and lines that a finding remembers of each sort.
pub const MOST_PLACES: usize = 400;

/// Where something is: at most [`MOST_PLACES`] of each sort, the first ones of the model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Places {
    /// Indices into the scene's surfaces.
    pub faces: Vec<u32>,
    /// Edges, and outlines of faces that were left out, metres.
    pub edges: Vec<[DVec3; 2]>,
    /// Points, metres.
    pub points: Vec<DVec3>,
    /// Lines of the OBJ file, from one.
    pub lines: Vec<u32>,
}

impl Places {
    /// Whether nothing can be pointed at.
    pub fn is_empty(&self) -> bool {
        self.faces.is_empty() && self.edges.is_empty() && self.points.is_empty()
    }

    /// Faces alone.
    pub(crate) fn of_faces(faces: impl IntoIterator<Item = u32>) -> Self {
        Self { faces: faces.into_iter().take(MOST_PLACES).collect(), ..Self::default() }
    }

    /// Adds an edge where there is room.
    pub(crate) fn add_edge(&mut self, edge: [DVec3; 2]) {
        if self.edges.len() < MOST_PLACES {
            self.edges.push(edge);
        }
    }

    /// Adds a point where there is room.
    pub(crate) fn add_point(&mut self, point: DVec3) {
        if self.points.len() < MOST_PLACES {
            self.points.push(point);
        }
    }
}

/// Something that was noticed about a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// What it is about.
    pub kind: FindingKind,
    /// How much it matters.
    pub severity: Severity,
    /// One sentence with names, counts and what was done about it.
    pub message: String,
    /// What the solver makes of it, as the end of a sentence; empty where the message tells.
    pub consequence: &'static str,
    /// How many faces, edges or materials it concerns.
    pub count: usize,
    /// Where it is.
    pub places: Places,
    /// The unit and the up axis that would set it right.
    pub remedy: Option<(LengthUnit, UpAxis)>,
}

impl Finding {
    /// One thing that has no place.
    pub(crate) fn new(kind: FindingKind, severity: Severity, message: impl Into<String>) -> Self {
        Self {
            kind,
            severity,
            message: message.into(),
            consequence: "",
            count: 1,
            places: Places::default(),
            remedy: None,
        }
    }

    /// Something that was not looked for, and why.
    pub(crate) fn unsearched(message: String) -> Self {
        Self::new(FindingKind::Unsearched, Severity::Note, message)
    }

    /// The same of `count` things.
    #[must_use]
    pub(crate) fn counted(self, count: usize) -> Self {
        Self { count, ..self }
    }

    /// The same with what the solver makes of it.
    #[must_use]
    pub(crate) fn with(self, consequence: &'static str) -> Self {
        Self { consequence, ..self }
    }

    /// The same with the unit and the up axis that would set it right.
    #[must_use]
    pub(crate) fn remedied(self, unit: LengthUnit, up: UpAxis) -> Self {
        Self { remedy: Some((unit, up)), ..self }
    }

    /// The same at these places.
    #[must_use]
    pub(crate) fn at(self, places: Places) -> Self {
        Self { places, ..self }
    }
}

impl fmt::Display for Finding {
    /// The message and what the solver makes of it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        if !self.consequence.is_empty() {
            write!(f, "; {}", self.consequence)?;
        }
        Ok(())
    }
}

/// `, line 12` or `, lines 3, 8, 9 and 4 more`; nothing where no line is known.
pub(super) fn line_list(lines: &[u32], all: usize) -> String {
    const SHOWN: usize = 5;
    let shown: Vec<String> = lines.iter().take(SHOWN).map(u32::to_string).collect();
    match shown[..] {
        [] => String::new(),
        [ref one] if all <= 1 => format!(", line {one}"),
        _ if all > shown.len() => format!(", lines {} and {} more", shown.join(", "), all - shown.len()),
        _ => format!(", lines {}", shown.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_lines_are_short() {
        assert_eq!(line_list(&[], 3), "");
        assert_eq!(line_list(&[7], 1), ", line 7");
        assert_eq!(line_list(&[7, 9], 2), ", lines 7, 9");
        assert_eq!(line_list(&[1, 2, 3, 4, 5, 6], 60), ", lines 1, 2, 3, 4, 5 and 55 more");
    }

    #[test]
    fn places_are_capped() {
        let mut places = Places::of_faces(0..10_000);
        assert_eq!(places.faces.len(), MOST_PLACES);
        (0..10_000).for_each(|_| places.add_point(DVec3::ZERO));
        assert_eq!(places.points.len(), MOST_PLACES);
    }
}
