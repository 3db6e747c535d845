//! Batches: a job list becomes a plan of trees, and the plan is carried out by any number of workers.
//!
//! A plan's items are independent, numbered and named by what they are, so any shard of it can run
//! anywhere, in any order, twice, and gives the same bytes.

mod jobs;
mod run;

pub use jobs::check_budgets;
pub use jobs::{Item, Job, JobList, Plan, PlanError, Seeds, Shard};
pub use run::{Observer, Outcome, RunOptions, run};
