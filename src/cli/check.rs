use super::failure::Failure;
use clap::Args;

/// Tell what a file holds and what is wrong with it
#[derive(Args, Debug)]
pub(super) struct Arguments {
    /// An OBJ file, or builtin:NAME
    #[arg(value_name = "SCENE")]
    scene: String,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    super::solve::load(&arguments.scene).map(drop)
}
