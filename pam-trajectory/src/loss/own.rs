//! Losses of other crates that files and command lines know by name.

use super::{AnyLoss, TrajectoryLoss};
use crate::settings::{SettingsError, require};
use pam_data::Recording;
use serde::de::DeserializeOwned;
use serde::ser::{Error, SerializeMap};
use serde::{Serialize, Serializer};
use serde_json::{Map, Value};
use std::fmt;
use std::sync::{Arc, PoisonError, RwLock};

/// A custom loss with the name that it has in curricula, sweeps and options, as in
/// `loss = { kind = "log_cosh", scale_mm = 0.2 }`.
///
/// Its settings are the fields of its serialized form. Those that a file leaves out are those of the value that was
/// [registered](register).
///
/// ```
/// use pam_data::Recording;
/// use pam_trajectory::loss::{NamedLoss, register};
/// use pam_trajectory::{AnyLoss, TrajectoryLoss};
/// use serde::{Deserialize, Serialize};
///
/// /// Mean of `(x − x_measured)⁴ / scale⁴`.
/// #[derive(Debug, Serialize, Deserialize)]
/// struct Quartic {
///     scale_mm: f64,
/// }
///
/// impl TrajectoryLoss for Quartic {
///     fn value_and_cotangents(&self, measured: &Recording, predicted: &[[f64; 4]], w: &mut [[f64; 4]]) -> f64 {
///         let share = 1.0 / predicted.len() as f64;
///         let mut sum = 0.0;
///         for ((p, x), w) in predicted.iter().zip(&measured.displacement_mm).zip(w) {
///             let e = (p[0] - x) / self.scale_mm;
///             sum += share * e.powi(4);
///             w[0] = 4.0 * share * e.powi(3) / self.scale_mm;
///         }
///         sum
///     }
/// }
///
/// impl NamedLoss for Quartic {
///     const NAME: &'static str = "quartic";
///     const DESCRIPTION: &'static str = "fourth power of the displacement error";
/// }
///
/// register(&Quartic { scale_mm: 0.5 })?;
/// let loss: AnyLoss = "quartic:scale_mm=0.2".parse()?;
/// assert_eq!(loss.name(), "quartic");
/// # Ok::<(), pam_trajectory::SettingsError>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no loss with a name",
    note = "implement `TrajectoryLoss` and `NamedLoss` for it, and derive `serde::Serialize` and `serde::Deserialize`"
)]
pub trait NamedLoss: TrajectoryLoss + Serialize + DeserializeOwned + Send + 'static {
    /// Its name; none of the built-in ones ([`AnyLoss::ALL`]).
    const NAME: &'static str;
    /// Description in one line.
    const DESCRIPTION: &'static str;
}

/// A [`NamedLoss`] as a value of [`AnyLoss`].
#[derive(Clone)]
pub struct OwnLoss {
    name: &'static str,
    /// Its serialized form: a table, or null without settings.
    settings: Value,
    loss: Arc<dyn TrajectoryLoss + Send>,
}

impl OwnLoss {
    /// The loss as a value.
    ///
    /// # Errors
    /// [`SettingsError`] if its serialized form is neither a table nor nothing.
    pub fn new<L: NamedLoss>(loss: &L) -> Result<Self, SettingsError> {
        let settings = serde_json::to_value(loss)
            .map_err(|e| SettingsError(format!("loss `{}`: {e}", L::NAME)))?;
        require(settings.is_object() || settings.is_null(), || {
            format!("loss `{}`: it must be a struct with named fields, or without any", L::NAME)
        })?;
        Self::with_settings::<L>(settings)
    }

    fn with_settings<L: NamedLoss>(settings: Value) -> Result<Self, SettingsError> {
        let loss: L = serde_json::from_value(settings.clone())
            .map_err(|e| SettingsError(format!("loss `{}`: {e}", L::NAME)))?;
        Ok(Self { name: L::NAME, settings, loss: Arc::new(loss) })
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }
}

impl TrajectoryLoss for OwnLoss {
    fn value_and_cotangents(
        &self,
        measured: &Recording,
        predicted: &[[f64; 4]],
        cotangents: &mut [[f64; 4]],
    ) -> f64 {
        self.loss.value_and_cotangents(measured, predicted, cotangents)
    }

    fn check(&self) -> Result<(), SettingsError> {
        self.loss.check()
    }
}

impl PartialEq for OwnLoss {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && self.settings == other.settings
    }
}

impl fmt::Debug for OwnLoss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.name, self.settings)
    }
}

/// As the losses with built-in names: a table with `kind` and the settings.
impl Serialize for OwnLoss {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut table = serializer.serialize_map(None)?;
        table.serialize_entry("kind", self.name)?;
        match &self.settings {
            Value::Object(fields) => {
                for (key, value) in fields {
                    table.serialize_entry(key, value)?;
                }
            }
            Value::Null => {}
            _ => return Err(S::Error::custom("the settings of a loss are a table")),
        }
        table.end()
    }
}

/// A registered loss from the table of a file.
type Read = fn(Value) -> Result<OwnLoss, SettingsError>;

struct Registered {
    default: OwnLoss,
    description: &'static str,
    read: Read,
}

/// Losses of [`AnyLoss`] other than the built-in ones. Entries are added and never replaced.
static REGISTERED: RwLock<Vec<Registered>> = RwLock::new(Vec::new());

/// Makes a loss known by its name to everything in this process that reads names: curricula, sweeps and options. Its
/// settings are those that hold where a file leaves them out. To do so twice is no error.
///
/// # Errors
/// [`SettingsError`] if another loss, or this one with other settings, has the name.
pub fn register<L: NamedLoss>(loss: &L) -> Result<AnyLoss, SettingsError> {
    let default = OwnLoss::new(loss)?;
    let taken = |what: &str| {
        Err(SettingsError(format!(
            "loss `{}`: there is {what} of this name already; give yours another name",
            L::NAME
        )))
    };
    if AnyLoss::ALL.iter().any(|(name, _)| *name == L::NAME) {
        return taken("a built-in one");
    }
    let mut registered = REGISTERED.write().unwrap_or_else(PoisonError::into_inner);
    let read: Read = OwnLoss::with_settings::<L>;
    match registered.iter().find(|r| r.default.name == L::NAME) {
        Some(known) if known.default == default && std::ptr::fn_addr_eq(known.read, read) => {}
        Some(_) => return taken("another one"),
        None => registered.push(Registered {
            default: default.clone(),
            description: L::DESCRIPTION,
            read,
        }),
    }
    Ok(AnyLoss::Own(default))
}

/// Name and one-line description of every loss that was [registered](register), in that order.
#[must_use]
pub fn registered() -> Vec<(&'static str, &'static str)> {
    let registered = REGISTERED.read().unwrap_or_else(PoisonError::into_inner);
    registered.iter().map(|r| (r.default.name, r.description)).collect()
}

/// The registered loss that a table with `kind` describes; `None` if the kind is no registered one.
pub(super) fn read(table: &Value) -> Option<Result<OwnLoss, SettingsError>> {
    let registered = REGISTERED.read().unwrap_or_else(PoisonError::into_inner);
    let name = table["kind"].as_str()?;
    let known = registered.iter().find(|r| r.default.name == name)?;
    let given = table.as_object()?.iter().filter(|(key, _)| *key != "kind");
    Some(overlaid(&known.default, given).and_then(known.read))
}

/// The settings of a loss with some of them replaced.
fn overlaid<'a>(
    default: &OwnLoss,
    given: impl Iterator<Item = (&'a String, &'a Value)>,
) -> Result<Value, SettingsError> {
    let mut settings = default.settings.clone();
    let mut none = Map::new();
    for (key, value) in given {
        let fields = settings.as_object_mut().unwrap_or(&mut none);
        let known = fields.keys().cloned().collect::<Vec<_>>().join(", ");
        *fields.get_mut(key).ok_or_else(|| {
            let known =
                if known.is_empty() { "it has none".into() } else { format!("it has {known}") };
            SettingsError(format!("loss `{}`: no setting `{key}`; {known}", default.name))
        })? = value.clone();
    }
    Ok(settings)
}
