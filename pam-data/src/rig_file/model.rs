//! The model that a rig file describes.

use super::schema::{FileLayout, Filters, RigFile};
use crate::error::DataError;
use crate::{document, toml_file};
use pam_core::units::GAS_COEFFICIENT_KPA_MM3_PER_G;
use pam_core::{JointModel, MuscleGeometry, PhysicalParameters, SpringDamper};
use std::path::Path;

/// Specific gas constant of dry air, kPa·mm³/(g·K): R/M = 8.314 462 618 / 28.9647 (Picard and others 2008, CIPM-2007).
const AIR_KPA_MM3_PER_G_K: f64 = 8.314_462_618 / 28.9647 * 1e6;
/// 0 °C in K.
const ZERO_CELSIUS_K: f64 = 273.15;

impl RigFile {
    /// Reads a rig file and checks it.
    ///
    /// # Errors
    /// [`DataError`] with the line if the file is not TOML or has a key that is not known; naming the key if a unit does
    /// not exist, needs a size that is not given, or a size is not positive.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, DataError> {
        Self::read_at(path.as_ref())
    }

    /// One instance, whatever the path is given as.
    fn read_at(path: &Path) -> Result<Self, DataError> {
        Self::parse(&toml_file::text(path)?, path)
    }

    /// Reads a rig file from text; `path` is for messages.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn parse(text: &str, path: impl AsRef<Path>) -> Result<Self, DataError> {
        Self::parse_at(text, path.as_ref())
    }

    /// One instance, whatever the path is given as.
    fn parse_at(text: &str, path: &Path) -> Result<Self, DataError> {
        let rig: Self = toml_file::parse(text, path)?;
        rig.validate().map_err(|message| DataError::file(path, message))?;
        Ok(rig)
    }

    /// The file as TOML.
    ///
    /// # Panics
    /// Never: a rig file is a table of tables.
    #[must_use]
    pub fn to_toml(&self) -> String {
        document::to_toml(self).expect("a rig file is a table of tables")
    }

    /// The file as TOML on one line.
    ///
    /// # Panics
    /// Never: a rig file is a table of tables.
    #[must_use]
    pub fn to_inline(&self) -> String {
        toml_file::inline(self).expect("a rig file is a table of tables")
    }

    /// Reads a rig file from TOML on one line.
    ///
    /// # Errors
    /// A sentence naming the key.
    pub fn from_inline(text: &str) -> Result<Self, String> {
        let Some(toml::Value::Table(table)) = toml_file::single_value(text) else {
            return Err(format!("`{text}` is no table of TOML on one line"));
        };
        let rig: Self = toml_file::from_table(&table)?;
        rig.validate()?;
        Ok(rig)
    }

    /// Checks sizes and units.
    ///
    /// # Errors
    /// A sentence naming the key.
    pub fn validate(&self) -> Result<(), String> {
        let (drive, muscles, air) = (&self.drive, &self.muscles, &self.air);
        let positive = [
            ("file.rate_hz", self.file.rate_hz),
            ("drive.pulley_radius_mm", drive.pulley_radius_mm),
            ("drive.torque_constant_nm_per_a", drive.torque_constant_nm_per_a),
            ("drive.gear_ratio", drive.gear_ratio),
            ("muscles.radius_mm", muscles.radius_mm),
            ("muscles.length_mm", muscles.length_mm),
            ("muscles.deformation", muscles.deformation),
            ("joint.mass_kg", self.joint.mass_kg),
            ("joint.inertia_kg_m2", self.joint.inertia_kg_m2),
            ("air.atmosphere_kpa", Some(air.atmosphere_kpa)),
            ("air.mass_flexor_g", air.mass_flexor_g),
            ("air.mass_extensor_g", air.mass_extensor_g),
            ("filter.displacement_hz", self.filter.displacement_hz),
            ("filter.pressure_hz", self.filter.pressure_hz),
            ("filter.force_hz", self.filter.force_hz),
            ("limits.force_n", self.limits.force_n),
        ];
        for (key, value) in positive {
            if let Some(value) = value
                && !(value.is_finite() && value > 0.0)
            {
                return Err(format!("{key} must be positive, got {value}"));
            }
        }
        for (key, value) in
            [("air.rest_s", air.rest_s), ("filter.velocity_hz", self.filter.velocity_hz)]
        {
            if !(value.is_finite() && value >= 0.0) {
                return Err(format!("{key} must not be negative, got {value}"));
            }
        }
        if let Some(angle) = muscles.braid_angle_deg
            && !(angle > 0.0 && angle < 54.7)
        {
            return Err(format!(
                "muscles.braid_angle_deg must be between 0 and 54.7 (where a braid no longer contracts), got {angle}"
            ));
        }
        let one_of = [
            (
                "muscles.braid_angle_deg",
                muscles.braid_angle_deg,
                "muscles.deformation",
                muscles.deformation,
            ),
            ("joint.mass_kg", self.joint.mass_kg, "joint.inertia_kg_m2", self.joint.inertia_kg_m2),
        ];
        for (a, first, b, second) in one_of {
            if first.is_some() && second.is_some() {
                return Err(format!("{a} and {b} say the same; give one of them"));
            }
        }
        if self.joint.inertia_kg_m2.is_some() && drive.pulley_radius_mm.is_none() {
            return Err("joint.inertia_kg_m2 needs drive.pulley_radius_mm".into());
        }
        if air.mass_flexor_g.is_some() != air.mass_extensor_g.is_some() {
            return Err("give both of air.mass_flexor_g and air.mass_extensor_g, or none".into());
        }
        if let Some(temperature) = air.temperature_c
            && !(-60.0..=150.0).contains(&temperature)
        {
            return Err(format!("air.temperature_c is {temperature}; it is in °C"));
        }
        for (key, range) in [
            ("limits.pressure_kpa", self.limits.pressure_kpa),
            ("limits.displacement_mm", self.limits.displacement_mm),
        ] {
            if let Some([low, high]) = range
                && low.partial_cmp(&high) != Some(std::cmp::Ordering::Less)
            {
                return Err(format!("{key} must be [lowest, highest], got [{low}, {high}]"));
            }
        }
        self.check_columns()
    }

    /// The same without layout and columns: what holds for a recording wherever it is stored, in columns of other names and
    /// after its filters.
    #[must_use]
    pub fn sizes(&self) -> Self {
        let Filters { displacement_hz, pressure_hz, force_hz, .. } = self.filter;
        let filtered = displacement_hz.or(pressure_hz).or(force_hz).is_some();
        Self {
            file: FileLayout::default(),
            columns: None,
            filter: Filters { in_file: filtered, ..self.filter },
            ..self.clone()
        }
    }

    /// The size of the muscles; that of the published rig where the file does not say it.
    #[must_use]
    pub fn geometry(&self) -> MuscleGeometry {
        let published = MuscleGeometry::default();
        MuscleGeometry {
            radius_mm: self.muscles.radius_mm.unwrap_or(published.radius_mm),
            length_mm: self.muscles.length_mm.unwrap_or(published.length_mm),
        }
    }

    /// Mass, gas coefficient and deformation coefficient of the data sheet; those of the published rig where the file
    /// does not say them.
    #[must_use]
    pub fn physical(&self) -> PhysicalParameters<f64> {
        let published = PhysicalParameters::datasheet();
        let by_inertia = |inertia: f64| {
            self.drive.pulley_radius_mm.map(|radius| inertia / (radius * 1e-3).powi(2))
        };
        let mass_kg = self
            .joint
            .mass_kg
            .or_else(|| self.joint.inertia_kg_m2.and_then(by_inertia))
            .unwrap_or(published.mass_kg);
        let by_angle = |angle: f64| angle.to_radians().tan().powi(-2);
        let deformation = self
            .muscles
            .deformation
            .or_else(|| self.muscles.braid_angle_deg.map(by_angle))
            .unwrap_or(published.deformation);
        let gas_coefficient =
            self.air.temperature_c.map_or(GAS_COEFFICIENT_KPA_MM3_PER_G, |celsius| {
                AIR_KPA_MM3_PER_G_K * (celsius + ZERO_CELSIUS_K)
            });
        PhysicalParameters { mass_kg, gas_coefficient, deformation }
    }

    /// The force of two ideal braided muscles of this size, as a straight line around x = 0.
    ///
    /// With `A = π r₀²` and `ν = cot² α` a muscle pulls with `P_gauge A (3 ν (1 − ε)² − (1 + ν))` (Chou and Hannaford 1996,
    /// equation 13); the air is sealed and isothermal. The damping is half of the critical one at four atmospheres. Real
    /// joints are up to six times stiffer: the published one is.
    #[must_use]
    pub fn spring_damper(&self) -> SpringDamper<f64> {
        let (p, g) = (self.physical(), self.geometry());
        let (nu, length) = (p.deformation, g.length_mm);
        let area_mm2 = std::f64::consts::PI * g.radius_mm * g.radius_mm;
        let gas = 2.0 * nu - 1.0;
        // Both muscles: the braid's own slope goes with the gauge, that of the sealed air with the absolute pressure.
        let per_kpa = area_mm2 / length * (6.0 * nu + gas * gas);
        let stiffness_mn_mm = -12.0 * nu * area_mm2 * self.air.atmosphere_kpa / length;
        let kpa_per_g = p.gas_coefficient / (area_mm2 * length);
        let nominal = 2.0 * per_kpa * 4.0 * self.air.atmosphere_kpa + stiffness_mn_mm;
        SpringDamper {
            stiffness_mn_mm,
            stiffness_per_mass_mn_mm_g: per_kpa * kpa_per_g,
            shift_per_mass_mm_g: area_mm2 * gas * kpa_per_g / nominal,
            damping_kg_s: (nominal * p.mass_kg).sqrt(),
        }
    }

    /// A model of this rig's data sheet with a force.
    #[must_use]
    pub fn model<F>(&self, force: F) -> JointModel<f64, F> {
        JointModel {
            raw: self.physical().to_raw(),
            geometry: self.geometry(),
            auxiliary_damping_kg_s: 0.0,
            force,
        }
    }
}
