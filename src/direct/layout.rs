//! Direct light for every hour: elements as the lamps and the sky ask for them, and the sun of an hour on top.
//!
//! What corners see of each part of the sky is kept, so that the sky of another hour is one sparse product. The sun
//! moves its shadows: it is looked for anew at all corners, and elements are divided along its new edges. Those
//! divisions are of that hour alone, so that a day leaves no more elements behind than an hour does.

use super::elements::{Element, Elements, NO_ELEMENT};
use super::first_views::first_views;
use super::light::{DirectLight, Scratch, Views};
use super::refine::{ElementSettings, Found, NARROWED, Refinement, gathered, inset, places, with_scratch};
use crate::emitters::{Share, Source};
use crate::mesh::PatchMesh;
use crate::watch::{Cancelled, Watch};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Direct light laid out at one hour, to be lit at any.
#[derive(Clone, Debug, Default)]
pub struct Layout {
    /// With the light of the lamps and of the sky at that hour, without the sun.
    base: Elements,
    /// What the parts of the sky counted then.
    shares: Vec<Option<Share>>,
    /// Mean light that errors were counted against, W/m².
    mean: f64,
}

/// The bases of the sun and that alone, where it shines.
fn sun_of(mesh: &PatchMesh, light: &DirectLight) -> Option<(Range<u32>, DirectLight)> {
    let sun = mesh.outdoors.as_ref()?.sun;
    let all = &light.emitters().bases;
    let first = all.iter().position(|basis| basis.lamp == sun)?;
    let bases =
        first as u32..(first + all[first..].iter().take_while(|basis| basis.lamp == sun).count()) as u32;
    let alone = light.keeping(|source| is_of(source, &bases));
    (!alone.emitters().sources.is_empty()).then_some((bases, alone))
}

fn is_of(source: &Source, bases: &Range<u32>) -> bool {
    source.shares.iter().any(|share| bases.contains(&share.basis))
}

/// What is found at each corner, by what the elements may see.
fn at_corners(
    elements: &Elements,
    light: &DirectLight,
    views: &[Arc<Views>],
    watch: &mut Watch<'_>,
) -> Result<Vec<Found>, Cancelled> {
    watch.map(&places(elements, inset(light)), |corner, place| match place {
        Some((element, point)) => {
            gathered(light, *point, elements.corners[corner].normal, &views[*element as usize])
        }
        None => Found::default(),
    })
}

impl Layout {
    /// Divides the triangles of a mesh by the direct light of lamps and sky.
    ///
    /// # Errors
    /// The watch ended it.
    pub fn build(
        mesh: &PatchMesh,
        light: &DirectLight,
        settings: &ElementSettings,
        watch: &mut Watch<'_>,
    ) -> Result<Self, Cancelled> {
        let sun = sun_of(mesh, light);
        let without;
        let steady = match &sun {
            Some((bases, _)) => {
                without = light.keeping(|source| !is_of(source, bases));
                &without
            }
            None => light,
        };
        // 1. The corners of the mesh, seen from their elements.
        let mut elements = Elements::roots_of(mesh, settings.smooth);
        let views = first_views(&elements, mesh, steady, &mut watch.part(0.0, 0.35))?;
        for found in at_corners(&elements, steady, &views, &mut watch.part(0.35, 0.45))? {
            elements.push_light(&found.light);
            elements.parts.push(&found.parts);
        }
        // 2. What they have of the sun: errors count against all light.
        let mut besides = Vec::new();
        if let Some((_, sun)) = &sun {
            let views = first_views(&elements, mesh, sun, &mut watch.part(0.45, 0.45))?;
            let exitance = &settings.exitance;
            let found = at_corners(&elements, sun, &views, &mut watch.part(0.45, 0.45))?;
            let watts = |&(basis, value): &(u32, f32)| f64::from(value) * exitance[basis as usize];
            let watts = |found: &Found| found.light.iter().map(watts).sum();
            besides = found.iter().map(watts).collect();
        }
        // 3. Those that are worst, pass by pass.
        let seen_from = elements.elements.iter().map(|element| elements.area(element)).collect();
        let mut refinement = Refinement::new((mesh, steady), settings, elements, (views, seen_from), None);
        refinement.measure_mean(&besides);
        let mean = refinement.mean;
        let base = refinement.run(mesh, &mut watch.part(0.45, 1.0))?;
        Ok(Self { base, shares: light.emitters().parts(), mean })
    }

    /// The elements with the light of the hour that `light` is of: lamps as they were laid out, the sky by what is seen
    /// of its parts, the sun looked for anew, with elements divided along the edges of its shadows.
    ///
    /// # Errors
    /// The watch ended it.
    pub fn lit(
        &self,
        mesh: &PatchMesh,
        light: &DirectLight,
        settings: &ElementSettings,
        watch: &mut Watch<'_>,
    ) -> Result<Elements, Cancelled> {
        let Some((bases, sun)) = sun_of(mesh, light) else {
            let mut elements = self.base.unlit();
            self.steady(light).iter().for_each(|found| elements.push_light(&found.light));
            return Ok(elements);
        };
        // 1. What each leaf may see of the sun.
        let mut elements = self.base.unlit();
        let (views, seen_from) = self.views(mesh, &sun, &mut watch.part(0.0, 0.3))?;
        // 2. All light at the corners that there are.
        let found = at_corners(&elements, &sun, &views, &mut watch.part(0.3, 0.6))?;
        for (mut steady, found) in self.steady(light).into_iter().zip(found) {
            found.light.iter().for_each(|&(basis, value)| steady.add(basis, value));
            elements.push_light(&steady.light);
        }
        // 3. Its edges.
        let mut refinement =
            Refinement::new((mesh, &sun), settings, elements, (views, seen_from), Some(bases));
        refinement.measure_mean(&[]);
        let mean = refinement.mean;
        let mut lit = refinement.run(mesh, &mut watch.part(0.6, 1.0))?;
        let of_base = if mean > 0.0 { self.base.expected_error * self.mean / mean } else { 0.0 };
        lit.expected_error = lit.expected_error.hypot(of_base);
        Ok(lit)
    }

    /// As [`Self::lit`], at once: the sun by a few rays at the corners that lamps and sky have asked for. The trees are
    /// the same at every hour.
    ///
    /// # Errors
    /// The watch ended it.
    pub fn glimpsed(
        &self,
        mesh: &PatchMesh,
        light: &DirectLight,
        watch: &mut Watch<'_>,
    ) -> Result<Elements, Cancelled> {
        let mut elements = self.base.unlit();
        let mut found = self.steady(light);
        if let Some((_, sun)) = sun_of(mesh, light) {
            let places = places(&elements, inset(&sun));
            let by_sun = watch.map(&places, |corner, place| {
                let mut seen: Vec<(u32, f32)> = Vec::new();
                let Some((element, point)) = place else { return seen };
                let element = &elements.elements[*element as usize];
                if mesh.patches[element.patch as usize].buried {
                    return seen;
                }
                let normal = elements.corners[corner].normal;
                for source in &sun.emitters().sources {
                    let value = with_scratch(|scratch| sun.by_few_rays(source, (*point, normal), scratch));
                    seen.extend(source.shares.iter().map(|share| (share.basis, share.of(value) as f32)));
                }
                seen
            })?;
            for (found, seen) in found.iter_mut().zip(by_sun) {
                seen.iter().filter(|seen| seen.1 > 0.0).for_each(|&(basis, value)| found.add(basis, value));
            }
        }
        found.iter().for_each(|found| elements.push_light(&found.light));
        Ok(elements)
    }

    /// The light of lamps and sky at the corners.
    fn steady(&self, light: &DirectLight) -> Vec<Found> {
        let shares = light.emitters().parts();
        let corners = 0..self.base.corners.len();
        // At the hour that it was laid out at it is known exactly.
        if shares == self.shares {
            let known = |corner| Found { light: self.base.light_at(corner).to_vec(), ..Found::default() };
            return (0..self.base.corners.len() as u32).into_par_iter().map(known).collect();
        }
        let of_sky = |basis: u32| shares.iter().flatten().any(|share| share.basis == basis);
        let of_sky: Vec<bool> = (0..light.emitters().bases.len() as u32).map(of_sky).collect();
        let at = |corner: usize| {
            let mut found = Found::default();
            let lamps = self.base.light_at(corner as u32).iter();
            found.light.extend(lamps.filter(|entry| !of_sky[entry.0 as usize]));
            let mut sky: Vec<(u32, f64)> = Vec::new();
            self.base.parts.light(corner, &shares, |basis, value| {
                match sky.iter_mut().find(|sum| sum.0 == basis) {
                    Some(sum) => sum.1 += value,
                    None => sky.push((basis, value)),
                }
            });
            for (basis, value) in sky.into_iter().filter(|sum| sum.1 > 0.0) {
                found.add(basis, value as f32);
            }
            found
        };
        corners.into_par_iter().map(at).collect()
    }

    /// What each leaf may see of the sun, and the area of the element that it was looked for from, m².
    fn views(
        &self,
        mesh: &PatchMesh,
        sun: &DirectLight,
        watch: &mut Watch<'_>,
    ) -> Result<(Vec<Arc<Views>>, Vec<f64>), Cancelled> {
        let elements = &self.base;
        let whole = elements.regions.len();
        let mut views = first_views(elements, mesh, sun, &mut watch.part(0.0, 0.7))?;
        let area = |element: &Element| elements.area(element);
        let mut seen_from: Vec<f64> = elements.elements.iter().map(area).collect();
        // Each tree from its root down.
        let roots: Vec<(u32, Arc<Views>)> = (0..whole as u32).zip(views[..whole].iter().cloned()).collect();
        let below = watch.part(0.7, 1.0).map(&roots, |_, (root, own)| {
            let mut scratch = Scratch::default();
            let mut found: Vec<(u32, Arc<Views>, f64)> = Vec::new();
            let mut stack = vec![(*root, Arc::clone(own), seen_from[*root as usize])];
            while let Some((at, views, from)) = stack.pop() {
                let children = elements.elements[at as usize].children;
                if at != *root {
                    found.push((at, Arc::clone(&views), from));
                }
                if children == NO_ELEMENT {
                    continue;
                }
                for child in [children, children + 1] {
                    let element = &elements.elements[child as usize];
                    let size = elements.area(element);
                    if views.is_clear() || views.is_sampled() || size > NARROWED * from {
                        stack.push((child, Arc::clone(&views), from));
                        continue;
                    }
                    let normal = elements.normal(element, mesh);
                    let cell = elements.positions(element);
                    let narrowed = sun.narrowed(&views, &cell, normal, &mut scratch);
                    stack.push((child, Arc::new(narrowed), size));
                }
            }
            found
        })?;
        for (element, own, from) in below.into_iter().flatten() {
            views[element as usize] = own;
            seen_from[element as usize] = from;
        }
        Ok((views, seen_from))
    }
}
