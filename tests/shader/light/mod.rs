//! One file per file of `shaders/light/`.

mod alias_table;
mod disk;
mod environment;
mod rectangle;
mod sphere;
mod spot;
mod triangle;
