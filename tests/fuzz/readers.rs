//! What the readers of files must hold for any bytes: a scene without a wrong number in it, or one
//! sentence that names the file. Shared by the fuzz targets and by plain tests.

use lumenwalk::export::parse_points;
use lumenwalk::scene::{Summary, check, from_text};

pub(crate) const OBJ: &str = "mtllib room.mtl\n\
    v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 0 0 5\nv 4 0 5\nv 4 3 5\nv 0 3 5\n\
    v 1 2.9 1\nv 2 2.9 1\nv 2 2.9 2\nv 1 2.9 2\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\n\
    o room\nusemtl white\nf 1/1/1 2/2/1 3/3/1 4/1/1\nf 5 8 7 6\nf 1 5 6 2\nf 4 3 7 8\nf 1 4 8 5\nf 2 6 7 3\n\
    o lamp\nusemtl light\nf -4 -3 -2 -1\n";
pub(crate) const MTL: &str =
    "newmtl white\nKd 0.7 0.7 0.7\nmap_Kd paper.png\nnewmtl light\nKd 0 0 0\nKe 5 5 5\n";
pub(crate) const SIDECAR: &str = "unit = \"m\"\nup = \"y\"\nstart = \"Door\"\npatch_size = 0.2\n\
    [[view]]\nname = \"Door\"\neye = [1, 1.6, 4]\ntarget = [2, 1, 0]\nfov = 70\n\
    [[luminaire]]\nobject = \"lamp\"\nname = \"Ceiling lamp\"\nlumens = 800\ncct = 2700\n\
    [[material]]\nname = \"white\"\nreflectance = [0.8, 0.8, 0.8]\nsides = \"auto\"\n";
pub(crate) const POINTS: &str =
    "x,y,z,nx,ny,nz\n# probes\n1,0,1,0,1,0\n-0.75,5e-1,0.75,0,3,0\n1,1.8,1,0,1,0\n";

/// An OBJ with good materials and a good sidecar.
pub(crate) fn obj(data: &[u8]) -> bool {
    scene(&String::from_utf8_lossy(data), MTL, Some(SIDECAR))
}

/// A material library under a good OBJ.
pub(crate) fn mtl(data: &[u8]) -> bool {
    scene(OBJ, &String::from_utf8_lossy(data), None)
}

/// A sidecar of a good OBJ.
pub(crate) fn sidecar(data: &[u8]) -> bool {
    scene(OBJ, MTL, Some(&String::from_utf8_lossy(data)))
}

/// A file of points.
pub(crate) fn points(data: &[u8]) -> bool {
    match parse_points("points.csv", &String::from_utf8_lossy(data)) {
        Ok(points) => {
            assert!(!points.is_empty());
            for point in points {
                assert!(point.position.is_finite() && (point.normal.length() - 1.0).abs() < 1e-9);
            }
            true
        }
        Err(error) => {
            let message = error.to_string();
            assert!(message.contains("points.csv") && !message.contains('\n'), "{message:?}");
            false
        }
    }
}

/// Reads a scene and looks at every number in it; whether it was accepted.
pub(crate) fn scene(obj: &str, mtl: &str, sidecar: Option<&str>) -> bool {
    let scene = match from_text("room", obj, mtl, sidecar) {
        Ok(scene) => scene,
        Err(error) => {
            let message = error.to_string();
            assert!(message.contains("room.") && !message.contains('\n'), "{message:?}");
            return false;
        }
    };
    check(&scene);
    let _ = Summary::of(&scene).to_string();
    assert!(scene.positions.iter().all(|p| p.is_finite()));
    assert!(scene.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-9));
    assert!(scene.materials.iter().flat_map(|m| m.reflectance).all(|r| (0.0..=1.0).contains(&r)));
    let outputs = scene.luminaires.iter().flat_map(|l| l.initial.output());
    assert!(outputs.into_iter().all(|e| e.is_finite() && e >= 0.0));
    assert!(scene.views.iter().all(|v| v.eye.is_finite() && v.eye != v.target));
    assert!(scene.start_view < scene.views.len());
    for surface in &scene.surfaces {
        let area = lumenwalk::geometry::polygon::area_vector(&scene.polygon(surface));
        assert!(area.length() > 0.0 && area.is_finite());
        assert!(surface.emission_weight.iter().all(|w| (0.0..=1.0).contains(w)));
    }
    true
}
