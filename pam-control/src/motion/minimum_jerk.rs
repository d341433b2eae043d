use super::{Motion, MotionPoint};

/// One reach of least jerk from rest to rest: with `τ = (t − delay) / duration`,
///
/// ```text
/// x = from + (to − from) (10 τ³ − 15 τ⁴ + 6 τ⁵)
/// ```
///
/// T. Flash and N. Hogan, *The coordination of arm movements* (1985), equation A4. Before and after it
/// the joint rests.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MinimumJerk {
    /// Start, mm.
    pub from_mm: f64,
    /// End, mm.
    pub to_mm: f64,
    /// Duration of the reach, s.
    pub duration_s: f64,
    /// Rest before it, s.
    pub delay_s: f64,
}

impl Motion for MinimumJerk {
    fn at(&self, time_s: f64) -> MotionPoint {
        let tau = ((time_s - self.delay_s) / self.duration_s).clamp(0.0, 1.0);
        let way = self.to_mm - self.from_mm;
        let place = tau.powi(3) * (10.0 - 15.0 * tau + 6.0 * tau * tau);
        let slope = 30.0 * (tau * (1.0 - tau)).powi(2);
        let bend = 60.0 * tau * (1.0 - tau) * (1.0 - 2.0 * tau);
        MotionPoint {
            displacement_mm: self.from_mm + way * place,
            velocity_mm_s: way * slope / self.duration_s,
            acceleration_mm_s2: way * bend / (self.duration_s * self.duration_s),
        }
    }
}
