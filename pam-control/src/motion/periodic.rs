use super::{Motion, MotionPoint};
use std::f64::consts::TAU;

/// `x = centre + amplitude · sin(2π f t)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sine {
    /// Middle of the motion, mm.
    pub centre_mm: f64,
    /// Amplitude, mm.
    pub amplitude_mm: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
}

impl Motion for Sine {
    fn at(&self, time_s: f64) -> MotionPoint {
        let omega = TAU * self.frequency_hz;
        let (sine, cosine) = (omega * time_s).sin_cos();
        MotionPoint {
            displacement_mm: self.centre_mm + self.amplitude_mm * sine,
            velocity_mm_s: omega * self.amplitude_mm * cosine,
            acceleration_mm_s2: -omega * omega * self.amplitude_mm * sine,
        }
    }
}

/// Straight lines between the turning points of a [`Sine`]. The acceleration is zero: that at the
/// turning points is infinite, and no air gives it. At a turning point the velocity is that after it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Triangle {
    /// Middle of the motion, mm.
    pub centre_mm: f64,
    /// Amplitude, mm.
    pub amplitude_mm: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
}

impl Motion for Triangle {
    fn at(&self, time_s: f64) -> MotionPoint {
        let quarter = 4.0 * (self.frequency_hz * time_s).rem_euclid(1.0);
        let speed = 4.0 * self.frequency_hz * self.amplitude_mm;
        let (place, velocity_mm_s) = match quarter {
            q if q < 1.0 => (q, speed),
            q if q < 3.0 => (2.0 - q, -speed),
            q => (q - 4.0, speed),
        };
        MotionPoint {
            displacement_mm: self.centre_mm + self.amplitude_mm * place,
            velocity_mm_s,
            acceleration_mm_s2: 0.0,
        }
    }
}

/// Rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hold {
    /// Where, mm.
    pub displacement_mm: f64,
}

impl Motion for Hold {
    fn at(&self, _time_s: f64) -> MotionPoint {
        MotionPoint {
            displacement_mm: self.displacement_mm,
            velocity_mm_s: 0.0,
            acceleration_mm_s2: 0.0,
        }
    }
}
