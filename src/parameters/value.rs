//! What a parameter can be.

use std::fmt;

/// A parameter's value, of one of the kinds that ROS 2 has.
#[derive(Debug, Clone, PartialEq)]
pub enum ParameterValue {
    /// None: whoever sets this wants the parameter gone.
    NotSet,
    /// True or false.
    Bool(bool),
    /// A whole number.
    Integer(i64),
    /// A number.
    Double(f64),
    /// A text.
    Text(String),
    /// Bytes.
    Bytes(Vec<u8>),
    /// True or false, a list.
    Bools(Vec<bool>),
    /// Whole numbers, a list.
    Integers(Vec<i64>),
    /// Numbers, a list.
    Doubles(Vec<f64>),
    /// Texts, a list.
    Texts(Vec<String>),
}

impl ParameterValue {
    /// The kind's number in `rcl_interfaces/msg/ParameterType`.
    pub fn type_number(&self) -> u8 {
        match self {
            Self::NotSet => 0,
            Self::Bool(_) => 1,
            Self::Integer(_) => 2,
            Self::Double(_) => 3,
            Self::Text(_) => 4,
            Self::Bytes(_) => 5,
            Self::Bools(_) => 6,
            Self::Integers(_) => 7,
            Self::Doubles(_) => 8,
            Self::Texts(_) => 9,
        }
    }

    /// The kind in words.
    pub(super) fn kind(&self, length: Option<usize>) -> String {
        let several = |what: &str| match length {
            Some(length) => format!("{length} {what}"),
            None => format!("a list of {what}"),
        };
        match self {
            Self::NotSet => "nothing".to_owned(),
            Self::Bool(_) => "true or false".to_owned(),
            Self::Integer(_) => "a whole number".to_owned(),
            Self::Double(_) => "a number".to_owned(),
            Self::Text(_) => "text".to_owned(),
            Self::Bytes(_) => several("bytes"),
            Self::Bools(_) => several("truth values"),
            Self::Integers(_) => several("whole numbers"),
            Self::Doubles(_) => several("numbers"),
            Self::Texts(_) => several("texts"),
        }
    }

    /// The same as one of `other`'s kind, if it can be meant as one.
    pub(super) fn converted(self, other: &Self) -> Option<Self> {
        // So ROS's reader of parameter files says `[]`.
        let is_empty = self.length() == Some(0) || self == Self::NotSet;
        match (self, other) {
            (Self::Integer(number), Self::Double(_)) => Some(Self::Double(number as f64)),
            (Self::Integers(numbers), Self::Doubles(_)) => {
                Some(Self::Doubles(numbers.iter().map(|number| *number as f64).collect()))
            }
            // A list of none has no kind: tools make one up.
            (_, Self::Bytes(_)) if is_empty => Some(Self::Bytes(Vec::new())),
            (_, Self::Bools(_)) if is_empty => Some(Self::Bools(Vec::new())),
            (_, Self::Integers(_)) if is_empty => Some(Self::Integers(Vec::new())),
            (_, Self::Doubles(_)) if is_empty => Some(Self::Doubles(Vec::new())),
            (_, Self::Texts(_)) if is_empty => Some(Self::Texts(Vec::new())),
            (value, other) => (value.type_number() == other.type_number()).then_some(value),
        }
    }

    /// How many there are, of a list.
    pub(super) fn length(&self) -> Option<usize> {
        match self {
            Self::Bytes(list) => Some(list.len()),
            Self::Bools(list) => Some(list.len()),
            Self::Integers(list) => Some(list.len()),
            Self::Doubles(list) => Some(list.len()),
            Self::Texts(list) => Some(list.len()),
            _ => None,
        }
    }

    /// Its numbers, one or a list.
    pub fn numbers(&self) -> &[f64] {
        match self {
            Self::Double(number) => std::slice::from_ref(number),
            Self::Doubles(numbers) => numbers,
            _ => &[],
        }
    }

    /// Its whole numbers, one or a list.
    pub fn whole(&self) -> &[i64] {
        match self {
            Self::Integer(number) => std::slice::from_ref(number),
            Self::Integers(numbers) => numbers,
            _ => &[],
        }
    }

    /// Its texts, one or a list.
    pub fn texts(&self) -> &[String] {
        match self {
            Self::Text(text) => std::slice::from_ref(text),
            Self::Texts(texts) => texts,
            _ => &[],
        }
    }

    /// Whether it is true; false of anything but a truth value.
    pub fn is_true(&self) -> bool {
        *self == Self::Bool(true)
    }
}

impl fmt::Display for ParameterValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotSet => write!(f, "not set"),
            Self::Bool(value) => write!(f, "{value}"),
            Self::Integer(value) => write!(f, "{value}"),
            Self::Double(value) => write!(f, "{value:?}"),
            Self::Text(value) => write!(f, "{value:?}"),
            Self::Bytes(value) => write!(f, "{value:?}"),
            Self::Bools(value) => write!(f, "{value:?}"),
            Self::Integers(value) => write!(f, "{value:?}"),
            Self::Doubles(value) => write!(f, "{value:?}"),
            Self::Texts(value) => write!(f, "{value:?}"),
        }
    }
}

macro_rules! from {
    ($($given:ty => $variant:ident),* $(,)?) => {$(
        impl From<$given> for ParameterValue {
            fn from(value: $given) -> Self {
                Self::$variant(value.into())
            }
        }
    )*};
}

from! {
    bool => Bool,
    i32 => Integer,
    i64 => Integer,
    f64 => Double,
    &str => Text,
    String => Text,
    Vec<u8> => Bytes,
    Vec<bool> => Bools,
    Vec<i64> => Integers,
    Vec<f64> => Doubles,
    Vec<String> => Texts,
}
