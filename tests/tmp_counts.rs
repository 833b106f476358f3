use lumenwalk::mesh::*;
use lumenwalk::scene::*;
#[test]
fn counts() {
    for (n, sizes) in [
        ("hemicube", vec![0.18]),
        ("cornell", vec![0.03]),
        ("house", vec![0.18, 0.2, 0.22, 0.24]),
        ("gallery", vec![0.29, 0.36, 0.4]),
    ] {
        let s = load(&SceneSource::Builtin(n.into())).unwrap();
        for f in &s.findings {
            println!("  {n} {:?} {}", f.severity, f.message);
        }
        for f in check(&s) {
            println!("  doctor {n} {:?} {}", f.severity, f.message);
        }
        for z in sizes {
            let m = build(&s, &MeshSettings { target: PatchTarget::Size(z), ..Default::default() }).unwrap();
            println!(
                "{n} {z} -> {} area {:.0} smallest {:.6} worst aspect {:.1} dark {} surfaces {}",
                m.patches.len(),
                m.statistics.area,
                m.statistics.smallest_area,
                m.statistics.worst_aspect,
                m.statistics.dark_sides,
                m.statistics.surfaces
            );
            if n == "house" && z == 0.18 || n == "gallery" && z == 0.29 {
                let mut h = std::collections::HashMap::new();
                let mut tiny = std::collections::HashMap::new();
                for p in &m.patches {
                    let o = s.objects[m.regions[p.region as usize].object as usize].clone()
                        + if p.side == Side::Back { " BACK" } else { "" };
                    *h.entry(o.clone()).or_insert(0) += 1;
                    if p.area < 2e-4 {
                        *tiny.entry(o).or_insert(0) += 1;
                    }
                }
                let mut v: Vec<_> = h.into_iter().collect();
                v.sort_by_key(|x| -x.1);
                println!("{:?}", &v[..60.min(v.len())]);
                println!("tiny {tiny:?}");
            }
        }
    }
}
