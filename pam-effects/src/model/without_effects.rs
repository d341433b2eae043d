use super::ExtendedModel;
use crate::effects::Absorbed;
use pam_data::SavedModel;

/// An extended model as a model without effects, for uses that know none: stiffness maps, planning.
#[derive(Debug, Clone)]
pub struct WithoutEffects {
    /// The model, with every effect that its own numbers can hold.
    pub saved: SavedModel,
    /// Effects that its numbers hold now.
    pub absorbed: Vec<&'static str>,
    /// Effects of instruments: the joint is as the model has it, its sensors or its drive are not.
    pub of_instruments: Vec<&'static str>,
    /// Effects that are missing in it.
    pub left_out: Vec<&'static str>,
}

impl WithoutEffects {
    /// A sentence on the fate of the effects; `None` if there were none.
    #[must_use]
    pub fn sentence(&self) -> Option<String> {
        let parts: Vec<String> = [
            (&self.absorbed, "is in its numbers"),
            (&self.of_instruments, "is of the instruments and does not change the joint"),
            (&self.left_out, "is left out: a model without effects cannot hold it"),
        ]
        .into_iter()
        .filter(|(ids, _)| !ids.is_empty())
        .map(|(ids, what)| format!("{} {what}", ids.join(", ")))
        .collect();
        (!parts.is_empty()).then(|| format!("extended model: {}", parts.join("; ")))
    }
}

impl ExtendedModel {
    /// The nearest model without effects: a factor of the force, a load, a damping, a mass or a coefficient of
    /// the volumes becomes part of the model's numbers, exactly.
    #[must_use]
    pub fn without_effects(&self) -> WithoutEffects {
        let mut joint = self.joint.clone();
        let (mut absorbed, mut of_instruments, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
        for active in &self.effects {
            let ids = match active.effect.absorb(&active.values, &mut joint) {
                Absorbed::Exactly => &mut absorbed,
                Absorbed::OfInstruments => &mut of_instruments,
                Absorbed::LeftOut => &mut left_out,
            };
            ids.push(active.effect.info().id);
        }
        let mut info = self.info.clone();
        info.effects.clear();
        WithoutEffects {
            saved: SavedModel { model: joint, info },
            absorbed,
            of_instruments,
            left_out,
        }
    }
}
