//! From outcomes to files: Parquet, summary and page.

mod page;
mod store;
mod summary;
mod synthetic;
