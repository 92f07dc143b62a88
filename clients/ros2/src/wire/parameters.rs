//! Messages and services of ROS 2 parameters (`rcl_interfaces`).

use super::standard::Time;
use super::{Byte, messages, services};

/// Kinds of parameter values.
pub mod kind {
    /// No value.
    pub const NOT_SET: u8 = 0;
    /// Floating-point number.
    pub const DOUBLE: u8 = 3;
}

messages! {
    /// Value of a parameter.
    ParameterValue as "rcl_interfaces/msg/ParameterValue" {
        /// Kind of the value.
        r#type: u8,
        /// Boolean.
        bool_value: bool,
        /// Integer.
        integer_value: i64,
        /// Floating-point number.
        double_value: f64,
        /// Text.
        string_value: String,
        /// Bytes.
        byte_array_value: Vec<Byte>,
        /// Booleans.
        bool_array_value: Vec<bool>,
        /// Integers.
        integer_array_value: Vec<i64>,
        /// Floating-point numbers.
        double_array_value: Vec<f64>,
        /// Texts.
        string_array_value: Vec<String>,
    }
    /// Parameter with its value.
    Parameter as "rcl_interfaces/msg/Parameter" {
        /// Name.
        name: String,
        /// Value.
        value: ParameterValue,
    }
    /// Result of a change.
    SetResult as "rcl_interfaces/msg/SetParametersResult" {
        /// True if the parameter has the new value.
        successful: bool,
        /// Cause of a rejection.
        reason: String,
    }
    /// Range of numbers.
    FloatRange as "rcl_interfaces/msg/FloatingPointRange" {
        /// Smallest value.
        from_value: f64,
        /// Largest value.
        to_value: f64,
        /// Step; 0 for any value.
        step: f64,
    }
    /// Range of integers.
    IntegerRange as "rcl_interfaces/msg/IntegerRange" {
        /// Smallest value.
        from_value: i64,
        /// Largest value.
        to_value: i64,
        /// Step.
        step: u64,
    }
    /// Description of a parameter.
    Descriptor as "rcl_interfaces/msg/ParameterDescriptor" {
        /// Name.
        name: String,
        /// Kind of the value.
        r#type: u8,
        /// Meaning and unit.
        description: String,
        /// Further limits as text.
        additional_constraints: String,
        /// True if the parameter cannot be changed.
        read_only: bool,
        /// True if its kind may change.
        dynamic_typing: bool,
        /// Range; at most one.
        floating_point_range: crate::wire::Bounded<FloatRange, 1>,
        /// Range; at most one.
        integer_range: crate::wire::Bounded<IntegerRange, 1>,
    }
    /// Names below prefixes.
    ListResult as "rcl_interfaces/msg/ListParametersResult" {
        /// Names of parameters.
        names: Vec<String>,
        /// Their prefixes.
        prefixes: Vec<String>,
    }
    /// Change of parameters.
    ParameterEvent as "rcl_interfaces/msg/ParameterEvent" {
        /// Time.
        stamp: Time,
        /// Node.
        node: String,
        /// New parameters.
        new_parameters: Vec<Parameter>,
        /// Changed parameters.
        changed_parameters: Vec<Parameter>,
        /// Deleted parameters.
        deleted_parameters: Vec<Parameter>,
    }
    /// Request of values.
    GetRequest as "rcl_interfaces/srv/GetParameters_Request" {
        /// Names.
        names: Vec<String>,
    }
    /// Values in the order of the names.
    GetResponse as "rcl_interfaces/srv/GetParameters_Response" {
        /// Values.
        values: Vec<ParameterValue>,
    }
    /// Request of kinds.
    GetTypesRequest as "rcl_interfaces/srv/GetParameterTypes_Request" {
        /// Names.
        names: Vec<String>,
    }
    /// Kinds in the order of the names.
    GetTypesResponse as "rcl_interfaces/srv/GetParameterTypes_Response" {
        /// Kinds.
        types: Vec<u8>,
    }
    /// Request of changes.
    SetRequest as "rcl_interfaces/srv/SetParameters_Request" {
        /// Parameters.
        parameters: Vec<Parameter>,
    }
    /// Results in the order of the parameters.
    SetResponse as "rcl_interfaces/srv/SetParameters_Response" {
        /// Results.
        results: Vec<SetResult>,
    }
    /// Request of changes, all or none.
    SetAllRequest as "rcl_interfaces/srv/SetParametersAtomically_Request" {
        /// Parameters.
        parameters: Vec<Parameter>,
    }
    /// Result of all changes.
    SetAllResponse as "rcl_interfaces/srv/SetParametersAtomically_Response" {
        /// Result.
        result: SetResult,
    }
    /// Request of names.
    ListRequest as "rcl_interfaces/srv/ListParameters_Request" {
        /// Prefixes; empty for all.
        prefixes: Vec<String>,
        /// Levels below the prefix; 0 for all.
        depth: u64,
    }
    /// Names.
    ListResponse as "rcl_interfaces/srv/ListParameters_Response" {
        /// Names.
        result: ListResult,
    }
    /// Request of descriptions.
    DescribeRequest as "rcl_interfaces/srv/DescribeParameters_Request" {
        /// Names.
        names: Vec<String>,
    }
    /// Descriptions in the order of the names.
    DescribeResponse as "rcl_interfaces/srv/DescribeParameters_Response" {
        /// Descriptions.
        descriptors: Vec<Descriptor>,
    }
}

services! {
    /// Returns values.
    GetParameters as "rcl_interfaces/srv/GetParameters": GetRequest => GetResponse;
    /// Returns kinds of values.
    GetParameterTypes as "rcl_interfaces/srv/GetParameterTypes":
        GetTypesRequest => GetTypesResponse;
    /// Changes values one by one.
    SetParameters as "rcl_interfaces/srv/SetParameters": SetRequest => SetResponse;
    /// Changes all values or none.
    SetParametersAtomically as "rcl_interfaces/srv/SetParametersAtomically":
        SetAllRequest => SetAllResponse;
    /// Returns names.
    ListParameters as "rcl_interfaces/srv/ListParameters": ListRequest => ListResponse;
    /// Returns descriptions.
    DescribeParameters as "rcl_interfaces/srv/DescribeParameters":
        DescribeRequest => DescribeResponse;
}
