//! Which hooks an effect has.

#[cfg(doc)]
use super::Effect;

/// The hooks of an [`Effect`] that are not neutral. The others are not called in the steps of a simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hooks {
    /// [`Effect::rest`].
    pub rest: bool,
    /// [`Effect::drive`].
    pub drive: bool,
    /// [`Effect::force_mn`].
    pub force: bool,
    /// [`Effect::dry_friction_mn`].
    pub dry_friction: bool,
    /// [`Effect::air_g_s`].
    pub air_flow: bool,
    /// [`Effect::advance`].
    pub advance: bool,
    /// [`Effect::delay_s`], [`Effect::inertia_kg`] or [`Effect::chamber`].
    pub constants: bool,
    /// [`Effect::delay_s`]: simulations then carry its derivative even at zero delay.
    pub delay: bool,
    /// [`Effect::observe`].
    pub observe: bool,
}

impl Hooks {
    /// None.
    pub const NONE: Self = Self {
        rest: false,
        drive: false,
        force: false,
        dry_friction: false,
        air_flow: false,
        advance: false,
        constants: false,
        delay: false,
        observe: false,
    };

    /// All of them.
    pub const ALL: Self = Self {
        rest: true,
        drive: true,
        force: true,
        dry_friction: true,
        air_flow: true,
        advance: true,
        constants: true,
        delay: true,
        observe: true,
    };

    /// Those of either.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            rest: self.rest || other.rest,
            drive: self.drive || other.drive,
            force: self.force || other.force,
            dry_friction: self.dry_friction || other.dry_friction,
            air_flow: self.air_flow || other.air_flow,
            advance: self.advance || other.advance,
            constants: self.constants || other.constants,
            delay: self.delay || other.delay,
            observe: self.observe || other.observe,
        }
    }

    /// Whether the effect acts on sensors only and leaves the motion of the joint unchanged.
    #[must_use]
    pub fn leave_the_motion(self) -> bool {
        self == Self { observe: self.observe, ..Self::NONE }
    }
}
