use glam::DVec3;

/// A right-handed orthonormal frame whose third axis is a surface normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First axis, in the surface.
    pub tangent: DVec3,
    /// Second axis, in the surface: `normal x tangent`.
    pub bitangent: DVec3,
    /// Third axis, of unit length.
    pub normal: DVec3,
}

impl Frame {
    /// Any frame around the unit vector `normal` (Duff et al. 2017, without a branch on the axes).
    pub fn around(normal: DVec3) -> Self {
        let sign = 1.0_f64.copysign(normal.z);
        let a = -1.0 / (sign + normal.z);
        let b = normal.x * normal.y * a;
        Self {
            tangent: DVec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
            bitangent: DVec3::new(b, sign + normal.y * normal.y * a, -normal.y),
            normal,
        }
    }

    /// The frame around `normal` whose tangent points as near to `direction` as it can.
    ///
    /// Falls back to [`Frame::around`] where `direction` is parallel to the normal.
    pub fn along(normal: DVec3, direction: DVec3) -> Self {
        let tangent = (direction - normal * normal.dot(direction)).normalize_or_zero();
        if tangent == DVec3::ZERO {
            return Self::around(normal);
        }
        Self { tangent, bitangent: normal.cross(tangent), normal }
    }

    /// The frame turned about its normal by `angle` radians.
    pub fn turned(self, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self {
            tangent: self.tangent * cos + self.bitangent * sin,
            bitangent: self.bitangent * cos - self.tangent * sin,
            normal: self.normal,
        }
    }

    /// Components of a world vector in this frame: (tangent, bitangent, normal).
    pub fn local(&self, world: DVec3) -> DVec3 {
        DVec3::new(self.tangent.dot(world), self.bitangent.dot(world), self.normal.dot(world))
    }

    /// The world vector with these components in this frame.
    pub fn world(&self, local: DVec3) -> DVec3 {
        self.tangent * local.x + self.bitangent * local.y + self.normal * local.z
    }
}
