//! What a scene holds, in numbers.

use super::luminaires::lumens;
use super::types::{LengthUnit, Scene, UpAxis, illuminance};
use crate::geometry::{Aabb, polygon};
use std::fmt;

/// What a scene holds: the figures that `lumenwalk check` prints.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Name of the scene.
    pub name: String,
    /// Where it comes from.
    pub source: String,
    /// The file's unit.
    pub unit: LengthUnit,
    /// Which way is up.
    pub up: UpAxis,
    /// Polygons.
    pub surfaces: usize,
    /// Polygons with smooth normals.
    pub smooth_surfaces: usize,
    /// Distinct corner positions.
    pub positions: usize,
    /// Objects and groups.
    pub objects: usize,
    /// A box around everything, metres.
    pub bounds: Aabb,
    /// Area of all surfaces, one side each, m².
    pub area: f64,
    /// One entry a material.
    pub materials: Vec<MaterialSummary>,
    /// One entry a luminaire.
    pub luminaires: Vec<LuminaireSummary>,
    /// Names of the views, that from which one starts first.
    pub views: Vec<String>,
    /// Decoded images.
    pub textures: usize,
}

/// A material and where it is used.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialSummary {
    /// Name in the MTL file.
    pub name: String,
    /// Diffuse reflectance per band; with an image, the factor on it.
    pub reflectance: [f64; 3],
    /// Whether an image modulates it.
    pub textured: bool,
    /// Polygons that use it.
    pub surfaces: usize,
    /// Their area, one side each, m².
    pub area: f64,
}

/// A lamp and how strong it is.
#[derive(Clone, Debug, PartialEq)]
pub struct LuminaireSummary {
    /// What the user reads.
    pub name: String,
    /// Emitting area, m².
    pub area: f64,
    /// Luminous flux at full output, lm.
    pub lumens: f64,
    /// Luminous flux as switched and dimmed at first, lm.
    pub initial_lumens: f64,
    /// Polygons that it is made of.
    pub surfaces: usize,
    /// Of the sky the illuminance of the open horizontal, of the sun that of a surface which faces it, lx; their flux is
    /// without bounds.
    pub lux: Option<f64>,
}

impl Summary {
    /// Counts and measures a scene.
    pub fn of(scene: &Scene) -> Self {
        let areas: Vec<f64> =
            scene.surfaces.iter().map(|s| polygon::area_vector(&scene.polygon(s)).length()).collect();
        let materials = scene.materials.iter().enumerate().map(|(index, material)| {
            let used = scene.surfaces.iter().zip(&areas).filter(|(s, _)| s.material as usize == index);
            let (surfaces, area) = used.fold((0, 0.0), |(n, sum), (_, area)| (n + 1, sum + area));
            MaterialSummary {
                name: material.name.clone(),
                reflectance: material.reflectance,
                textured: material.texture.is_some(),
                surfaces,
                area,
            }
        });
        let luminaires = scene.luminaires.iter().zip(lumens(scene)).enumerate();
        let luminaires = luminaires.map(|(index, (luminaire, [full, initial]))| LuminaireSummary {
            name: luminaire.name.clone(),
            area: luminaire.area,
            lumens: full,
            initial_lumens: initial,
            surfaces: scene.surfaces.iter().filter(|s| s.luminaire == Some(index as u32)).count(),
            lux: scene
                .outdoors
                .as_ref()
                .filter(|outdoors| [outdoors.sky, outdoors.sun].contains(&(index as u32)))
                .map(|_| illuminance(luminaire.initial.exitance)),
        });
        let start = scene.views.iter().skip(scene.start_view).take(1);
        let others = scene.views.iter().enumerate().filter(|(i, _)| *i != scene.start_view).map(|(_, v)| v);
        Self {
            name: scene.name.clone(),
            source: scene.source.to_string(),
            unit: scene.unit,
            up: scene.up,
            surfaces: scene.surfaces.len(),
            smooth_surfaces: scene
                .surfaces
                .iter()
                .filter(|s| s.corners.iter().any(|c| c.normal.is_some()))
                .count(),
            positions: scene.positions.len(),
            objects: scene.objects.len(),
            bounds: scene.extent().main,
            area: areas.iter().sum(),
            materials: materials.collect(),
            luminaires: luminaires.collect(),
            views: start.chain(others).map(|view| view.name.clone()).collect(),
            textures: scene.textures.len(),
        }
    }
}

fn count(number: usize, noun: &str) -> String {
    format!("{number} {noun}{}", if number == 1 { "" } else { "s" })
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.bounds.size();
        let up = if self.up == UpAxis::Z { "z" } else { "y" };
        writeln!(f, "{} ({})", self.name, self.source)?;
        writeln!(
            f,
            "  surfaces    {}, {} of them smooth; {}; {}; {}",
            self.surfaces,
            self.smooth_surfaces,
            count(self.positions, "corner"),
            count(self.objects, "object"),
            count(self.textures, "image")
        )?;
        writeln!(f, "  extent      {:.3} x {:.3} x {:.3} m, {up} up", size.x, size.y, size.z)?;
        if self.unit != LengthUnit::Metre {
            let s = size / self.unit.metres();
            writeln!(
                f,
                "              {:.6} x {:.6} x {:.6} {} in the file",
                s.x,
                s.y,
                s.z,
                self.unit.symbol()
            )?;
        }
        writeln!(f, "  area        {:.3} m2", self.area)?;
        writeln!(f, "  views       {}", self.views.join(", "))?;
        // A name that no line holds is left to run over.
        const WIDEST: usize = 48;
        let width = |names: &mut dyn Iterator<Item = &str>| {
            names.map(|n| n.chars().count()).filter(|&n| n <= WIDEST).max().unwrap_or(0)
        };
        writeln!(f, "  materials   {}", self.materials.len())?;
        let column = width(&mut self.materials.iter().map(|m| m.name.as_str()));
        for material in &self.materials {
            let [r, g, b] = material.reflectance;
            let image = if material.textured { " x image" } else { "" };
            writeln!(
                f,
                "    {:column$}  reflectance {r:.3} {g:.3} {b:.3}{image}, {:.3} m2 in {}",
                material.name,
                material.area,
                count(material.surfaces, "surface")
            )?;
        }
        writeln!(f, "  luminaires  {}", self.luminaires.len())?;
        let column = width(&mut self.luminaires.iter().map(|l| l.name.as_str()));
        for lamp in &self.luminaires {
            if let Some(lux) = lamp.lux {
                writeln!(f, "    {:column$}  {lux:.0} lx in the open", lamp.name)?;
                continue;
            }
            let polygons = count(lamp.surfaces, "surface");
            write!(f, "    {:column$}  {:.0} lm, {:.4} m2 in {polygons}", lamp.name, lamp.lumens, lamp.area)?;
            match lamp.initial_lumens {
                output if output == lamp.lumens => writeln!(f)?,
                0.0 => writeln!(f, ", off")?,
                output => writeln!(f, ", dimmed to {output:.0} lm")?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::from_text;
    use super::*;

    #[test]
    fn a_summary_adds_up() {
        let obj = "mtllib m\nv 0 0 0\nv 100 0 0\nv 100 0 200\nv 0 0 200\nv 0 50 0\nv 100 50 0\nv 100 50 100\nv 0 50 100\n\
            usemtl floor\nf 4 3 2 1\no lamp\nusemtl light\nf 5 6 7 8\n";
        let mtl = "newmtl floor\nKd 0.25 0.5 0.75\nnewmtl light\nKd 0 0 0\n";
        let sidecar = "unit = \"cm\"\n[[luminaire]]\nmaterial = \"light\"\nlumens = 600\ndimmer = 0.5\n\
            [[view]]\nname = \"A\"\neye = [0, 100, 0]\ntarget = [1, 0, 0]\n[[view]]\nname = \"B\"\neye = [1, 1, 1]\ntarget = [0, 0, 0]\n";
        let scene = from_text("t", obj, mtl, Some(&format!("start = \"b\"\n{sidecar}"))).unwrap();
        let summary = Summary::of(&scene);
        assert!((summary.area - 3.0).abs() < 1e-12);
        assert_eq!(summary.views, ["B", "A"]);
        assert_eq!(summary.materials[0].reflectance, [0.25, 0.5, 0.75]);
        assert!((summary.materials[0].area - 2.0).abs() < 1e-12);
        assert!((summary.luminaires[0].lumens - 600.0).abs() < 1e-9);
        assert!((summary.luminaires[0].initial_lumens - 300.0).abs() < 1e-9);
        let text = summary.to_string();
        for words in [
            "1.000 x 0.500 x 2.000 m, y up",
            "100.000000 x 50.000000 x 200.000000 cm",
            "dimmed to 300 lm",
            "0.250 0.500 0.750",
        ] {
            assert!(text.contains(words), "{words}: {text}");
        }
    }
}
