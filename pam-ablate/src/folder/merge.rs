//! Folders of shards into one.

use super::{CellRecord, Planned, Status, SweepFolder, claim};
use crate::error::AblateError;
use crate::sweep::Sweep;
use std::path::Path;

/// Takes the results of several folders of one sweep over into one folder. Of a cell that is over in
/// several, one that is done is preferred to one that failed, then the first. Returns for how many cells
/// there is a result now.
///
/// # Errors
/// [`AblateError::Folder`] if a folder holds another sweep, or two have different numbers for the same
/// cell.
pub fn merge(
    sources: &[&Path],
    target: &SweepFolder,
    sweep: &Sweep,
    planned: &[Planned],
) -> Result<usize, AblateError> {
    for source in sources {
        if !SweepFolder::at(source).sweep()?.same_as(sweep) {
            return Err(AblateError::folder(
                source,
                "it holds another sweep than the first folder; only shards of one sweep can be merged",
            ));
        }
    }
    let mut found = 0;
    for p in planned {
        let mut best = target.read_record(&p.id)?;
        let mut changed = false;
        for source in sources {
            let Some(record) = SweepFolder::at(source).read_record(&p.id)? else { continue };
            match &best {
                None => (best, changed) = (Some(record), true),
                Some(b) if b.status == Status::Failed && record.status == Status::Done => {
                    (best, changed) = (Some(record), true);
                }
                Some(b) if conflicting(b, &record) => {
                    return Err(AblateError::folder(
                        &SweepFolder::at(source).cell(&p.id),
                        format!(
                            "its numbers are not those of another folder for the same cell ({}); the \
                             recordings or the programs differed ({} and {}). Remove the wrong one",
                            p.cell.describe(sweep),
                            b.made_by,
                            record.made_by
                        ),
                    ));
                }
                Some(_) => {}
            }
        }
        if let Some(record) = &best {
            found += 1;
            if changed {
                target.write_record(record)?;
                // So that nobody who works in the folder begins it again.
                if let claim::Claimed::Mine(claim) = claim::Claim::take(target.cell(&p.id))? {
                    claim.over()?;
                }
            }
        }
    }
    Ok(found)
}

fn conflicting(a: &CellRecord, b: &CellRecord) -> bool {
    a.status == Status::Done && b.status == Status::Done && a.metrics != b.metrics
}
