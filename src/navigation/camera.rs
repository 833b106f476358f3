use crate::geometry::Ray;
use crate::scene::View;
use glam::{DMat4, DVec2, DVec3};

/// A pinhole camera in world space, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it stands.
    pub eye: DVec3,
    /// Unit vector along which it looks.
    pub forward: DVec3,
    /// Unit vector upwards; need not be perpendicular to `forward`.
    pub up: DVec3,
    /// Vertical field of view, degrees, 5 to 150.
    pub fov_y_deg: f64,
}

impl Camera {
    /// The camera at `eye` that looks at `target`; along -z where the two coincide.
    pub fn looking_at(eye: DVec3, target: DVec3, up: DVec3, fov_y_deg: f64) -> Self {
        Self { eye, forward: (target - eye).normalize_or(DVec3::NEG_Z), up, fov_y_deg }
    }

    /// The camera of a bookmark.
    pub fn from_view(view: &View, up: DVec3) -> Self {
        Self::looking_at(view.eye, view.target, up, view.fov_y_deg)
    }

    /// Orthonormal axes: right, up (perpendicular to the view), forward. Where the camera looks
    /// straight up or down, right is any horizontal direction.
    pub fn axes(&self) -> [DVec3; 3] {
        let forward = self.forward.normalize_or(DVec3::NEG_Z);
        let right = forward.cross(self.up);
        let right = if right.length_squared() > 1e-18 {
            right.normalize()
        } else {
            self.up.any_orthogonal_vector().normalize_or(DVec3::X)
        };
        [right, right.cross(forward), forward]
    }

    /// Half the extents of the image plane at distance 1.
    fn half_extents(&self, size_px: [u32; 2]) -> DVec2 {
        let fov = if self.fov_y_deg.is_finite() { self.fov_y_deg.clamp(1.0, 170.0) } else { 60.0 };
        let y = (0.5 * fov.to_radians()).tan();
        DVec2::new(y * f64::from(size_px[0].max(1)) / f64::from(size_px[1].max(1)), y)
    }

    /// What the picture spans at distance 1: half its width to the right, half its height upwards, and the unit
    /// vector forward.
    pub fn image_plane(&self, size_px: [u32; 2]) -> [DVec3; 3] {
        let [right, up, forward] = self.axes();
        let half = self.half_extents(size_px);
        [right * half.x, up * half.y, forward]
    }

    /// Clip space from positions relative to `origin`: y up, depth reversed (1 at distance `near`,
    /// 0 at infinity), as wgpu wants it. `near` in metres, above zero.
    pub fn clip_from_local(&self, origin: DVec3, size_px: [u32; 2], near: f64) -> DMat4 {
        let [right, up, forward] = self.axes();
        let half = self.half_extents(size_px);
        let eye = self.eye - origin;
        let row = |axis: DVec3, scale: f64| (axis * scale).extend(-axis.dot(eye) * scale);
        let depth = DVec3::ZERO.extend(near);
        DMat4::from_cols(row(right, 1.0 / half.x), row(up, 1.0 / half.y), depth, row(forward, 1.0))
            .transpose()
    }

    /// The ray through a point of the picture. `pixel` counts from the upper left corner, the
    /// centre of the first pixel being (0.5, 0.5). The direction is of unit length.
    pub fn ray(&self, pixel: DVec2, size_px: [u32; 2]) -> Ray {
        let [right, up, forward] = self.image_plane(size_px);
        let x = 2.0 * pixel.x / f64::from(size_px[0].max(1)) - 1.0;
        let y = 1.0 - 2.0 * pixel.y / f64::from(size_px[1].max(1));
        Ray { origin: self.eye, direction: (forward + right * x + up * y).normalize() }
    }

    /// Where a point appears, in pixels from the upper left corner; `None` behind the camera.
    /// The result may lie outside the picture.
    pub fn project(&self, point: DVec3, size_px: [u32; 2]) -> Option<DVec2> {
        let clip = self.clip_from_local(self.eye, size_px, 1.0) * (point - self.eye).extend(1.0);
        (clip.w > 1e-9).then(|| {
            let ndc = DVec2::new(clip.x, clip.y) / clip.w;
            0.5 * DVec2::new(1.0 + ndc.x, 1.0 - ndc.y)
                * DVec2::new(f64::from(size_px[0]), f64::from(size_px[1]))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera::looking_at(DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 2.5, -2.0), DVec3::Y, 50.0)
    }

    #[test]
    fn a_point_on_a_pixels_ray_projects_to_that_pixel() {
        let size = [640, 400];
        for pixel in [DVec2::new(0.5, 0.5), DVec2::new(320.0, 200.0), DVec2::new(600.0, 33.0)] {
            let ray = camera().ray(pixel, size);
            let there = camera().project(ray.origin + ray.direction * 7.0, size).expect("in front");
            assert!(there.distance(pixel) < 1e-9, "{there} for {pixel}");
        }
        assert_eq!(camera().project(camera().eye - camera().forward, size), None);
    }

    #[test]
    fn the_matrix_agrees_with_the_usual_one() {
        let c = camera();
        let view = glam::dcamera::rh::view::look_at_mat4(c.eye, c.eye + c.forward, c.up);
        let aspect = 640.0 / 400.0;
        let proj = glam::dcamera::rh::proj::directx::perspective_infinite_reverse(
            c.fov_y_deg.to_radians(),
            aspect,
            0.02,
        );
        let ours = c.clip_from_local(DVec3::ZERO, [640, 400], 0.02);
        assert!(ours.abs_diff_eq(proj * view, 1e-12), "{ours} and {}", proj * view);
    }

    #[test]
    fn looking_straight_down_has_axes() {
        let c = Camera { eye: DVec3::ZERO, forward: DVec3::NEG_Y, up: DVec3::Y, fov_y_deg: 60.0 };
        let [right, up, forward] = c.axes();
        assert!((right.cross(forward) - up).length() < 1e-12 && (right.length() - 1.0).abs() < 1e-12);
    }
}
