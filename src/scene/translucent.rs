//! Materials that pass light diffusely: cloth, paper, opal glass.

use super::types::{MAX_REFLECTANCE, Material};

/// Makes a material pass these shares of what arrives, per band, diffusely to its other side; it is no clear glass then,
/// whatever the MTL has. What it reflects is lowered to what is left, and then the end of a sentence that says so is
/// returned.
///
/// # Errors
/// Shares that cannot be, as the end of a sentence that begins with the name of the material.
pub(super) fn apply(shares: [f64; 3], material: &mut Material) -> Result<Option<String>, String> {
    if !shares.iter().all(|share| (0.0..=MAX_REFLECTANCE).contains(share)) {
        return Err(format!("has a translucence outside of 0 to {MAX_REFLECTANCE}"));
    }
    material.translucence = shares;
    if !material.is_translucent() {
        return Ok(None);
    }
    material.glazing = None;
    let before = material.reflectance;
    if material.texture.is_none() {
        for (rho, share) in material.reflectance.iter_mut().zip(shares) {
            *rho = rho.min(MAX_REFLECTANCE - share);
        }
    }
    let told = |[r, g, b]: [f64; 3]| match r == g && g == b {
        true => format!("{r:.2}"),
        false => format!("{r:.2} {g:.2} {b:.2}"),
    };
    Ok((material.reflectance != before).then(|| {
        format!(
            "reflects {} and not {}, since it passes {} and no surface sends out more than arrives",
            told(material.reflectance),
            told(before),
            told(shares)
        )
    }))
}

#[cfg(test)]
mod tests {
    use crate::scene::from_text;

    const OBJ: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl paper\nf 1 2 3\n";

    fn read(mtl: &str, entry: &str) -> Result<crate::scene::Scene, String> {
        let mtl = format!("newmtl paper\n{mtl}\n");
        let sidecar = format!("[[material]]\nname = \"paper\"\n{entry}\n");
        from_text("t", OBJ, &mtl, Some(&sidecar)).map_err(|error| error.to_string())
    }

    #[test]
    fn what_passes_and_what_is_reflected_are_no_more_than_arrives() {
        let scene = read("Kd .3 .3 .3", "translucence = 0.5").unwrap();
        let paper = &scene.materials[0];
        assert_eq!((paper.translucence, paper.reflectance), ([0.5; 3], [0.3; 3]));
        let told = |scene: &crate::scene::Scene| {
            scene.findings.iter().map(|f| f.message.clone()).collect::<Vec<_>>()
        };
        assert!(told(&scene).is_empty(), "{:?}", told(&scene));

        let scene = read("Kd .8 .4 .1", "translucence = [0.5, 0.5, 0.5]").unwrap();
        let [r, g, b] = scene.materials[0].reflectance;
        assert!((r - 0.48).abs() < 1e-12 && (g, b) == (0.4, 0.1), "{r} {g} {b}");
        let told = told(&scene).join("; ");
        assert!(told.contains("reflects 0.48 0.40 0.10 and not 0.80 0.40 0.10"), "{told}");
        assert!(told.contains("passes 0.50"), "{told}");
    }

    #[test]
    fn it_takes_the_place_of_clear_glass_and_is_refused_beside_it() {
        let scene = read("Kd .2 .2 .2\nd .3", "translucence = 0.4").unwrap();
        assert!(scene.materials[0].glazing.is_none() && scene.materials[0].is_translucent());
        assert!(read("d .3", "translucence = 0").unwrap().materials[0].glazing.is_some());
        for entry in ["translucence = 0.4\nglass = true", "translucence = 0.4\ntransmittance = 0.8"] {
            let refused = read("Kd .2 .2 .2", entry).unwrap_err();
            assert!(refused.contains("takes no translucence"), "{refused}");
        }
        for entry in ["translucence = -0.1", "translucence = 1.0", "translucence = nan"] {
            let refused = read("Kd .2 .2 .2", entry).unwrap_err();
            assert!(refused.contains("'paper' has a translucence outside of 0 to 0.98"), "{refused}");
        }
    }
}
