//! `diagnosis.json`.

use super::run::Diagnosis;
use serde_json::{Map, Value, json};

impl Diagnosis {
    /// The diagnosis as it is written; `model` is the path of the extended model.
    #[must_use]
    pub fn to_json(&self, model: &str) -> Value {
        let causes: Vec<Value> = self
            .causes
            .iter()
            .map(|c| {
                let parameters: Map<String, Value> =
                    c.parameters.iter().map(|(name, i)| ((*name).to_owned(), json!(i))).collect();
                json!({
                    "effect": c.effect,
                    "parameters": parameters,
                    "share_of_error_removed": c.share_of_error_removed,
                    "confusable_with": c.confusable_with,
                    "excited_by": c.excited_by,
                    "constancy": c.constancy,
                })
            })
            .collect();
        let ranking: Vec<Value> = self
            .ranking
            .iter()
            .map(|r| json!({ "effect": r.effect, "score": r.score, "at_limit": r.at_limit }))
            .collect();
        let channels: Map<String, Value> = self
            .residual
            .channels
            .iter()
            .zip(&self.left.channels)
            .map(|(c, left)| {
                let dependence: Map<String, Value> = c
                    .dependence
                    .iter()
                    .map(|d| (d.factor.replace(' ', "_"), json!(d.share)))
                    .collect();
                (
                    c.channel.to_owned(),
                    json!({
                        "unit": c.unit,
                        "rms": c.rms,
                        "rms_left": left.rms,
                        "floor": c.floor,
                        "mean": c.mean,
                        "next_correlation": c.next_correlation,
                        "dependence": dependence,
                        "lines": c.spectrum.lines(4),
                    }),
                )
            })
            .collect();
        let ordinary = self.ordinary.as_ref().map(|o| {
            json!({
                "effects": o.effects,
                "rms": o.rms,
                "recordings": o.recordings,
            })
        });
        json!({
            "verdict": self.verdict,
            "causes": causes,
            "ranking": ranking,
            "residual": { "channels": channels, "description": self.residual.description },
            "gain": self.gain,
            "ceiling": { "any_correction": self.ceiling, "named": self.removed },
            "chance": self.chance.map(|c| json!({
                "share_q95": c.share_q95,
                "largest_share": c.largest_share,
                "p_value": c.p_value,
                "draws": c.draws,
                "named_share": self.explained,
            })),
            "ordinary": ordinary,
            "force_lead_samples": self.force_lead_samples,
            "fitted": self.fitted,
            "judged_by": self.judged_by,
            "held_out": self.held_out,
            "model": model,
        })
    }
}
