use crate::form_factors::Method;
use crate::mesh::PatchTarget;
use crate::scene::SceneError;
use crate::solve::{PipelineError, SolveSettings};

/// What a case is about; the order is that of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Group {
    /// Form factors between two surfaces.
    ViewFactors,
    /// Form factors past something that stands between.
    Occlusion,
    /// Scenes from which light escapes.
    OpenScenes,
    /// Laws that hold in every closed scene.
    ClosedScenes,
    /// Whole solutions with a published or closed-form answer.
    Solutions,
    /// Glass and cloth that light passes.
    Panes,
    /// Lamps: small, hidden, weak, many.
    Lamps,
    /// Units, places, turns: what must not matter.
    Extremes,
}

impl Group {
    /// All groups in their order.
    pub const ALL: [Self; 8] = [
        Self::ViewFactors,
        Self::Occlusion,
        Self::OpenScenes,
        Self::ClosedScenes,
        Self::Solutions,
        Self::Panes,
        Self::Lamps,
        Self::Extremes,
    ];

    /// The heading in the table.
    pub fn name(self) -> &'static str {
        match self {
            Self::ViewFactors => "view factors",
            Self::Occlusion => "occlusion",
            Self::OpenScenes => "open scenes",
            Self::ClosedScenes => "closed scenes",
            Self::Solutions => "solutions",
            Self::Panes => "panes",
            Self::Lamps => "lamps",
            Self::Extremes => "extremes",
        }
    }
}

/// A way of computing a case's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Way {
    /// A formula for this very configuration.
    Formula,
    /// The contour integral between polygons, which the solver uses for close pairs.
    Contour,
    /// A solve with form factors by this method.
    By(Method),
}

impl Way {
    /// As the table names it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Formula => "formula",
            Self::Contour => "contour",
            Self::By(method) => method.name(),
        }
    }

    /// Settings of a solve this way at the method's resolution for cases; lines for a closed form.
    pub fn settings(self, patches: PatchTarget) -> SolveSettings {
        let method = match self {
            Self::By(method) => method,
            Self::Formula | Self::Contour => Method::Lines,
        };
        SolveSettings { patches, method, resolution: Some(resolution(method)), ..SolveSettings::default() }
    }
}

/// Lines and hemicube as by default; four times as many rays, whose noise falls slowly.
fn resolution(method: Method) -> u32 {
    match method {
        Method::Lines | Method::Hemicube | Method::AlignedHemicube => method.default_resolution(),
        Method::Rays => 4 * method.default_resolution(),
    }
}

/// Why a case gave no value.
#[derive(Debug, thiserror::Error)]
pub enum CaseError {
    /// Its scene could not be read.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Its scene could not be solved.
    #[error(transparent)]
    Solve(#[from] PipelineError),
    /// This way of computing does not apply to it.
    #[error("this case cannot be computed by {0}")]
    Way(&'static str),
}

type Compute = Box<dyn Fn(Way) -> Result<f64, CaseError> + Send + Sync>;

/// A value that is known, and the ways in which the program computes it.
pub struct Case {
    /// What it is about.
    pub group: Group,
    /// What is compared, in a few words; unique.
    pub name: String,
    /// Where the expected value comes from.
    pub source: &'static str,
    /// The value; not zero.
    pub expected: f64,
    /// Why the tolerances are what they are.
    pub reason: &'static str,
    /// Ways of computing it, each with the relative error that it is allowed.
    pub ways: Vec<(Way, f64)>,
    compute: Compute,
}

impl Case {
    pub(super) fn new(
        group: Group,
        name: impl Into<String>,
        source: &'static str,
        expected: f64,
        compute: impl Fn(Way) -> Result<f64, CaseError> + Send + Sync + 'static,
    ) -> Self {
        Self {
            group,
            name: name.into(),
            source,
            expected,
            reason: "",
            ways: Vec::new(),
            compute: Box::new(compute),
        }
    }

    pub(super) fn way(mut self, way: Way, tolerance: f64) -> Self {
        self.ways.push((way, tolerance));
        self
    }

    pub(super) fn lines(self, tolerance: f64) -> Self {
        self.way(Way::By(Method::Lines), tolerance)
    }

    pub(super) fn hemicube(self, tolerance: f64) -> Self {
        self.way(Way::By(Method::Hemicube), tolerance)
    }

    pub(super) fn rays(self, tolerance: f64) -> Self {
        self.way(Way::By(Method::Rays), tolerance)
    }

    /// All three methods with one tolerance.
    pub(super) fn all_methods(self, tolerance: f64) -> Self {
        self.lines(tolerance).hemicube(tolerance).rays(tolerance)
    }

    pub(super) fn because(mut self, reason: &'static str) -> Self {
        self.reason = reason;
        self
    }

    /// Computes it in one way and judges the result.
    pub fn run(&self, way: Way) -> Outcome {
        let tolerance = self.ways.iter().find(|w| w.0 == way).map_or(0.0, |w| w.1);
        let computed = (self.compute)(way);
        let error = computed.as_ref().ok().map(|value| (value - self.expected) / self.expected.abs());
        // A value that is no number passes no comparison.
        let passed = error.is_some_and(|error| error.abs() <= tolerance);
        Outcome { way, tolerance, computed, error, passed }
    }
}

impl std::fmt::Debug for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Case")
            .field("name", &self.name)
            .field("expected", &self.expected)
            .finish_non_exhaustive()
    }
}

/// What came of a case in one way.
#[derive(Debug)]
pub struct Outcome {
    /// How it was computed.
    pub way: Way,
    /// The relative error that is allowed.
    pub tolerance: f64,
    /// The value.
    pub computed: Result<f64, CaseError>,
    /// (computed - expected) / |expected|, where there is a value.
    pub error: Option<f64>,
    /// Whether the error is within the tolerance.
    pub passed: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(value: Result<f64, CaseError>) -> Outcome {
        let value = std::sync::Mutex::new(Some(value));
        Case::new(Group::Extremes, "a", "b", -2.0, move |_| {
            value.lock().map_or(Err(CaseError::Way("a")), |mut v| v.take().unwrap_or(Ok(0.0)))
        })
        .lines(0.1)
        .run(Way::By(Method::Lines))
    }

    #[test]
    fn a_verdict_is_strict() {
        assert!(case(Ok(-2.0)).passed && case(Ok(-1.81)).passed && case(Ok(-2.19)).passed);
        assert!(!case(Ok(-1.79)).passed && !case(Ok(2.0)).passed);
        assert!(!case(Ok(f64::NAN)).passed && !case(Ok(f64::INFINITY)).passed);
        assert!(!case(Err(CaseError::Way("formula"))).passed);
        assert_eq!(case(Ok(-1.0)).error, Some(0.5));
    }

    #[test]
    fn cases_are_many_named_once_and_explained() {
        let cases = crate::validate::cases();
        let mut names: Vec<&str> = cases.iter().map(|c| c.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), cases.len(), "names are unique");
        assert!(cases.len() >= 40, "{} cases", cases.len());
        for case in &cases {
            assert!(case.expected != 0.0 && case.expected.is_finite(), "{}", case.name);
            assert!(
                !case.ways.is_empty() && case.ways.iter().all(|w| w.1 > 0.0 && w.1 < 0.1),
                "{}",
                case.name
            );
            assert!(!case.source.is_empty() && !case.reason.is_empty(), "{}", case.name);
        }
        assert!(cases.is_sorted_by_key(|c| c.group), "group by group");
    }
}
