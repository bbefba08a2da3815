/// A number to be kept without supply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    /// Index and sub-index as [`object_dictionary::ObjectId::key`] gives them.
    pub key: u32,
    /// The value.
    pub value: u32,
}
