//! Protocols that are tried: within limits, drawn at random, mutated.

use pam_rig::protocol::CurrentSegment;
use pam_rig::{Conditions, Protocol};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;

/// Limits of the rig and of the model's validity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DesignLimits {
    /// Largest current, A.
    pub current_a: f64,
    /// Least and greatest sealed pressure, psi gauge.
    pub psi: [u8; 2],
    /// Least and greatest frequency, Hz.
    pub hz: [f64; 2],
    /// Largest displacement of the joint in the simulation, mm.
    pub travel_mm: f64,
    /// Largest speed of the joint in the simulation, mm/s.
    pub speed_mm_s: f64,
    /// Longest time with one current, s.
    pub hold_s: f64,
    /// Number of recordings.
    pub recordings: usize,
    /// Length of each recording, s.
    pub seconds: f64,
}

impl Default for DesignLimits {
    /// The range of the published recordings.
    fn default() -> Self {
        Self {
            current_a: 1.5,
            psi: [10, 80],
            hz: [0.05, 5.0],
            travel_mm: 5.0,
            speed_mm_s: f64::INFINITY,
            hold_s: f64::INFINITY,
            recordings: 3,
            seconds: 20.0,
        }
    }
}

/// Pressures of the standard, psi: training conditions of the published rig, from the middle outwards.
const STANDARD_PSI: [[u8; 2]; 8] =
    [[45, 45], [30, 60], [60, 30], [20, 20], [70, 70], [45, 30], [45, 60], [10, 80]];
/// Shortest segment, s.
const SHORTEST_S: f64 = 0.5;
/// Most segments of a protocol.
const MOST_SEGMENTS: usize = 6;
/// Grid of pressures, psi.
const STEP_PSI: i32 = 5;

/// The published excitation of the same length at as many conditions.
#[must_use]
pub fn standard(limits: &DesignLimits) -> Protocol {
    let psi = (0..limits.recordings).map(|k| STANDARD_PSI[k % STANDARD_PSI.len()]);
    let mut psi: Vec<[u8; 2]> = psi.collect();
    separate(&mut psi, limits);
    Protocol {
        conditions: Some(Conditions::List(psi)),
        ..Protocol::paper().with_duration(limits.seconds)
    }
}

/// Moves pairs of pressures that are there twice, as names of recordings tell them apart.
fn separate(psi: &mut [[u8; 2]], limits: &DesignLimits) {
    let [low, high] = limits.psi;
    for k in 0..psi.len() {
        psi[k] = psi[k].map(|p| p.clamp(low, high));
        while psi[..k].contains(&psi[k]) {
            let [f, e] = psi[k];
            psi[k] = if f < high {
                [f + 1, e]
            } else if e < high {
                [low, e + 1]
            } else {
                [low, low]
            };
        }
    }
}

/// A protocol as it is searched: pressures, and segments whose lengths are shares of the whole.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Proposal {
    pub(super) psi: Vec<[u8; 2]>,
    pub(super) segments: Vec<CurrentSegment>,
}

impl Proposal {
    pub(super) fn of(protocol: &Protocol) -> Self {
        let psi = protocol.conditions.as_ref().map(Conditions::psi).unwrap_or_default();
        Self { psi, segments: protocol.current.clone() }
    }

    pub(super) fn random(limits: &DesignLimits, random: &mut ChaCha8Rng) -> Self {
        let count = random.random_range(1..=MOST_SEGMENTS);
        let segments = (0..count).map(|_| segment(limits, random)).collect();
        let mut psi: Vec<[u8; 2]> = (0..limits.recordings)
            .map(|_| [pressure(limits, random), pressure(limits, random)])
            .collect();
        separate(&mut psi, limits);
        Self { psi, segments }.fitted(limits)
    }

    /// The proposal with one to three changes.
    pub(super) fn mutated(&self, limits: &DesignLimits, random: &mut ChaCha8Rng) -> Self {
        let mut made = self.clone();
        for _ in 0..random.random_range(1..=3) {
            let place = random.random_range(0..made.segments.len());
            match random.random_range(0..8) {
                0 | 1 => {
                    let run = random.random_range(0..made.psi.len());
                    let side = random.random_range(0..2);
                    let step = STEP_PSI * random.random_range(-4..=4);
                    let [low, high] = limits.psi.map(i32::from);
                    let own = &mut made.psi[run][side];
                    *own = (i32::from(*own) + step).clamp(low, high) as u8;
                }
                2 if made.segments.len() < MOST_SEGMENTS => {
                    made.segments.insert(place, segment(limits, random));
                }
                3 if made.segments.len() > 1 => {
                    made.segments.remove(place);
                }
                4 => made.segments[place] = segment(limits, random),
                5 => {
                    let own = &mut made.segments[place];
                    let length = own.duration_s() * factor(random);
                    *own = own.clone().with_duration(length);
                }
                6 => {
                    let other = random.random_range(0..made.segments.len());
                    made.segments.swap(place, other);
                }
                _ => change(&mut made.segments[place], limits, random),
            }
        }
        separate(&mut made.psi, limits);
        made.fitted(limits)
    }

    /// The segments together as long as a recording, none too short.
    fn fitted(mut self, limits: &DesignLimits) -> Self {
        let whole: f64 = self.segments.iter().map(CurrentSegment::duration_s).sum();
        let room = limits.seconds - SHORTEST_S * self.segments.len() as f64;
        let length = |own: f64| {
            let share = own / whole;
            if room > 0.0 { SHORTEST_S + room * share } else { limits.seconds * share }
        };
        self.segments = self
            .segments
            .into_iter()
            .map(|s| {
                let own = length(s.duration_s());
                shortened(s.with_duration(own))
            })
            .collect();
        self
    }

    /// The longest time with one current, s.
    pub(super) fn longest_hold_s(&self) -> f64 {
        let of = |s: &CurrentSegment| match s {
            CurrentSegment::Rest { duration_s } | CurrentSegment::Constant { duration_s, .. } => {
                *duration_s
            }
            CurrentSegment::Pulses { period_s, .. } => 0.5 * period_s,
            _ => 0.0,
        };
        self.segments.iter().map(of).fold(0.0, f64::max)
    }

    pub(super) fn protocol(&self, name: &str) -> Protocol {
        Protocol {
            name: name.into(),
            conditions: Some(Conditions::List(self.psi.clone())),
            suffix: Some(name.into()),
            current: self.segments.iter().cloned().map(rounded).collect(),
            ..Protocol::paper()
        }
    }
}

/// Steps whose pulses fit into half of their period.
fn shortened(segment: CurrentSegment) -> CurrentSegment {
    match segment {
        CurrentSegment::Pulses { amplitude_a, period_s, alternate, duration_s, .. } => {
            let period_s = period_s.min(duration_s);
            let width_ms = 499.0 * period_s;
            CurrentSegment::Pulses { amplitude_a, width_ms, period_s, alternate, duration_s }
        }
        other => other,
    }
}

/// Values with as many digits as a file should have.
fn rounded(segment: CurrentSegment) -> CurrentSegment {
    let n = |v: f64| (1e4 * v).round() / 1e4;
    use CurrentSegment as S;
    match segment {
        S::Rest { duration_s } => S::Rest { duration_s: n(duration_s) },
        S::Sine { amplitude_a, frequency_hz, duration_s } => S::Sine {
            amplitude_a: n(amplitude_a),
            frequency_hz: n(frequency_hz),
            duration_s: n(duration_s),
        },
        S::Multisine { components, duration_s } => S::Multisine {
            components: components.into_iter().map(|c| c.map(n)).collect(),
            duration_s: n(duration_s),
        },
        S::Triangle { amplitude_a, frequency_hz, duration_s } => S::Triangle {
            amplitude_a: n(amplitude_a),
            frequency_hz: n(frequency_hz),
            duration_s: n(duration_s),
        },
        S::Chirp { amplitude_a, from_hz, to_hz, duration_s } => S::Chirp {
            amplitude_a: n(amplitude_a),
            from_hz: n(from_hz),
            to_hz: n(to_hz),
            duration_s: n(duration_s),
        },
        S::Pulses { amplitude_a, width_ms, period_s, alternate, duration_s } => S::Pulses {
            amplitude_a: n(amplitude_a),
            width_ms: n(width_ms),
            period_s: n(period_s),
            alternate,
            duration_s: n(duration_s),
        },
        S::Constant { amplitude_a, duration_s } => {
            S::Constant { amplitude_a: n(amplitude_a), duration_s: n(duration_s) }
        }
        other => other,
    }
}

/// A factor around one.
fn factor(random: &mut ChaCha8Rng) -> f64 {
    (1.4 * (random.random::<f64>() - 0.5)).exp()
}

fn pressure(limits: &DesignLimits, random: &mut ChaCha8Rng) -> u8 {
    let [low, high] = limits.psi;
    let steps = (high - low) / STEP_PSI as u8;
    low + STEP_PSI as u8 * random.random_range(0..=steps)
}

/// A frequency, evenly in its logarithm.
fn frequency(limits: &DesignLimits, random: &mut ChaCha8Rng) -> f64 {
    let [low, high] = limits.hz.map(f64::ln);
    (low + random.random::<f64>() * (high - low)).exp()
}

fn amplitude(limits: &DesignLimits, random: &mut ChaCha8Rng) -> f64 {
    limits.current_a * (0.1 + 0.9 * random.random::<f64>().sqrt())
}

fn segment(limits: &DesignLimits, random: &mut ChaCha8Rng) -> CurrentSegment {
    let duration_s = limits.seconds * (0.05 + 0.5 * random.random::<f64>());
    let amplitude_a = amplitude(limits, random);
    let hz = frequency(limits, random);
    match random.random_range(0..8) {
        0 | 1 => CurrentSegment::Sine { amplitude_a, frequency_hz: hz, duration_s },
        2 | 3 => {
            let count = random.random_range(2..=5);
            let component = |_| {
                let phase = 360.0 * random.random::<f64>();
                [amplitude_a / f64::from(count), frequency(limits, random), phase]
            };
            CurrentSegment::Multisine {
                components: (0..count).map(component).collect(),
                duration_s,
            }
        }
        4 => {
            let to_hz = frequency(limits, random);
            CurrentSegment::Chirp { amplitude_a, from_hz: hz, to_hz, duration_s }
        }
        5 => CurrentSegment::Triangle { amplitude_a, frequency_hz: hz, duration_s },
        6 => {
            let period_s = hz.recip().clamp(0.2, duration_s);
            let width_ms = 499.0 * period_s;
            CurrentSegment::Pulses { amplitude_a, width_ms, period_s, alternate: true, duration_s }
        }
        _ => {
            let sign = if random.random::<bool>() { 1.0 } else { -1.0 };
            CurrentSegment::Constant { amplitude_a: sign * amplitude_a, duration_s }
        }
    }
}

/// Changes one number of a segment.
fn change(segment: &mut CurrentSegment, limits: &DesignLimits, random: &mut ChaCha8Rng) {
    let [low, high] = limits.hz;
    let most = limits.current_a;
    let by = factor(random);
    let which = random.random::<bool>();
    let hz = |f: &mut f64| *f = (*f * by).clamp(low, high);
    let a = |a: &mut f64| *a = (*a * by).clamp(-most, most);
    match segment {
        CurrentSegment::Sine { amplitude_a, frequency_hz, .. }
        | CurrentSegment::Triangle { amplitude_a, frequency_hz, .. } => {
            if which {
                a(amplitude_a)
            } else {
                hz(frequency_hz)
            }
        }
        CurrentSegment::Chirp { amplitude_a, from_hz, to_hz, .. } => {
            match random.random_range(0..3) {
                0 => a(amplitude_a),
                1 => hz(from_hz),
                _ => hz(to_hz),
            }
        }
        CurrentSegment::Multisine { components, .. } => {
            let place = random.random_range(0..components.len());
            if which {
                hz(&mut components[place][1])
            } else {
                components[place][0] *= by
            }
            let sum: f64 = components.iter().map(|c| c[0].abs()).sum();
            if sum > most {
                components.iter_mut().for_each(|c| c[0] *= most / sum);
            }
        }
        CurrentSegment::Pulses { amplitude_a, period_s, .. } => {
            if which {
                a(amplitude_a)
            } else {
                *period_s = (*period_s * by).max(0.2)
            }
        }
        CurrentSegment::Constant { amplitude_a, .. } => a(amplitude_a),
        _ => {}
    }
}
