use crate::scene::{Scene, SceneError, Sides, from_text};
use glam::{DVec3, dvec3};
use std::f64::consts::TAU;
use std::fmt::Write as _;

/// A scene in the making: texts of an OBJ and its materials, y upwards, lengths in metres unless a
/// sidecar says otherwise.
///
/// Scenes of cases go through the reader like any file, so that reading is checked as well.
#[derive(Clone, Debug, Default)]
pub struct Model {
    obj: String,
    mtl: String,
    corners: usize,
}

impl Model {
    /// Nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// A paint with reflectance `rho` in all bands, 0 to 1.
    pub fn grey(&mut self, name: &str, rho: f64) -> &mut Self {
        self.paint(name, [rho; 3], [0.0; 3])
    }

    /// A material with reflectances, 0 to 1, and exitances, W/m² a band.
    pub fn paint(&mut self, name: &str, rho: [f64; 3], exitance: [f64; 3]) -> &mut Self {
        // Writing to a string cannot fail.
        let [r, g, b] = rho;
        let _ = writeln!(self.mtl, "newmtl {name}\nKd {r} {g} {b}");
        if exitance.iter().any(|&e| e > 0.0) {
            let [r, g, b] = exitance.map(|e| e / std::f64::consts::PI);
            let _ = writeln!(self.mtl, "Ke {r:e} {g:e} {b:e}");
        }
        self
    }

    /// Polygons from here on belong to this object.
    pub fn object(&mut self, name: &str) -> &mut Self {
        let _ = writeln!(self.obj, "o {name}");
        self
    }

    /// A polygon, counter-clockwise from its front; metres.
    pub fn polygon(&mut self, material: &str, corners: &[DVec3]) -> &mut Self {
        for c in corners {
            let _ = writeln!(self.obj, "v {} {} {}", c.x, c.y, c.z);
        }
        let _ = write!(self.obj, "usemtl {material}\nf");
        for k in 1..=corners.len() {
            let _ = write!(self.obj, " {}", self.corners + k);
        }
        self.obj.push('\n');
        self.corners += corners.len();
        self
    }

    /// A parallelogram whose front looks along u x v; metres.
    pub fn quad(&mut self, material: &str, at: DVec3, u: DVec3, v: DVec3) -> &mut Self {
        self.polygon(material, &[at, at + u, at + u + v, at + v])
    }

    /// The inside of a box: objects floor, ceiling, west (low x), east, north (low z), south; one
    /// material each, `None` leaves it open.
    pub fn room(&mut self, low: DVec3, high: DVec3, materials: [Option<&str>; 6]) -> &mut Self {
        let size = high - low;
        let (x, y, z) = (DVec3::X * size.x, DVec3::Y * size.y, DVec3::Z * size.z);
        let faces: [(&str, DVec3, DVec3, DVec3); 6] = [
            ("floor", low, z, x),
            ("ceiling", low + y, x, z),
            ("west", low, y, z),
            ("east", low + x, z, y),
            ("north", low, x, y),
            ("south", low + z, y, x),
        ];
        for ((name, at, u, v), material) in faces.into_iter().zip(materials) {
            if let Some(material) = material {
                self.object(name).quad(material, at, u, v);
            }
        }
        self
    }

    /// The outside of a box, six faces of one object.
    pub fn block(&mut self, name: &str, material: &str, low: DVec3, high: DVec3) -> &mut Self {
        let size = high - low;
        let (x, y, z) = (DVec3::X * size.x, DVec3::Y * size.y, DVec3::Z * size.z);
        self.object(name);
        for (at, u, v) in
            [(low, x, z), (low + y, z, x), (low, z, y), (low + x, y, z), (low, y, x), (low + z, x, y)]
        {
            self.quad(material, at, u, v);
        }
        self
    }

    /// The inside of a sphere of unit radius between the heights z0 < z1, in rings of equal area cut
    /// into `around` facets; `material` names one a ring, counted from z0.
    pub fn sphere(
        &mut self,
        [z0, z1]: [f64; 2],
        [rings, around]: [usize; 2],
        material: &dyn Fn(usize) -> &'static str,
    ) -> &mut Self {
        let at = |ring: usize, k: usize| {
            let z = z0 + (z1 - z0) * ring as f64 / rings as f64;
            let angle = TAU * (k % around) as f64 / around as f64;
            let r = (1.0 - z * z).max(0.0).sqrt();
            dvec3(r * angle.cos(), r * angle.sin(), z)
        };
        self.object("sphere");
        for ring in 0..rings {
            for k in 0..around {
                let mut corners = vec![at(ring, k + 1), at(ring, k), at(ring + 1, k), at(ring + 1, k + 1)];
                corners.dedup_by(|a, b| a.distance(*b) < 1e-6);
                if corners[0].distance(corners[corners.len() - 1]) < 1e-6 {
                    corners.pop();
                }
                self.polygon(material(ring), &corners);
            }
        }
        self
    }

    /// Four rectangles of material `paint` around a lamp of material "glow", all facing down at height
    /// y of a room x by z: x from, x to, z from, z to.
    pub fn ceiling_with_lamp(&mut self, paint: &str, [x, y, z]: [f64; 3], lamp: [f64; 4]) -> &mut Self {
        let [x0, x1, z0, z1] = lamp;
        let parts = [[0.0, x, 0.0, z0], [0.0, x0, z0, z1], [x1, x, z0, z1], [0.0, x, z1, z]];
        for (material, [a, b, c, d]) in parts.map(|part| (paint, part)).into_iter().chain([("glow", lamp)]) {
            self.quad(material, dvec3(a, y, c), DVec3::X * (b - a), DVec3::Z * (d - c));
        }
        self
    }

    /// The OBJ (without `mtllib`) and the MTL as they stand.
    pub fn texts(&self) -> (&str, &str) {
        (&self.obj, &self.mtl)
    }

    /// Reads the texts, with a sidecar if one is given.
    ///
    /// # Errors
    /// As [`from_text`]: a mistake in the case itself.
    pub fn read(&self, sidecar: Option<&str>) -> Result<Scene, SceneError> {
        from_text("model", &format!("mtllib model.mtl\n{}", self.obj), &self.mtl, sidecar)
    }

    /// As [`Self::read`], with every surface taking part on its front alone: no search for light.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_one_sided(&self) -> Result<Scene, SceneError> {
        let mut scene = self.read(None)?;
        scene.materials.iter_mut().for_each(|m| m.sides = Sides::Front);
        Ok(scene)
    }
}
