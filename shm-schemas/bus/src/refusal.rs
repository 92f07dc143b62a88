//! Classification of iceoryx2's errors.

use std::fmt;

use iceoryx2::port::publisher::PublisherCreateError;
use iceoryx2::port::subscriber::SubscriberCreateError;
use iceoryx2::port::{LoanError, SendError};
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeCreateError as StreamCreateError, PublishSubscribeOpenError as StreamOpenError,
    PublishSubscribeOpenOrCreateError as StreamOpenOrCreateError,
};
use iceoryx2::service::builder::request_response::{
    RequestResponseCreateError as ExchangeCreateError,
    RequestResponseOpenError as ExchangeOpenError,
    RequestResponseOpenOrCreateError as ExchangeOpenOrCreateError,
};
use iceoryx2::service::port_factory::client::ClientCreateError;
use iceoryx2::service::port_factory::server::ServerCreateError;

/// Class of an iceoryx2 error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cause {
    /// May disappear when other processes finish their set-up.
    Transient,
    /// All slots are taken, some of them perhaps by dead nodes.
    NoSlot,
    /// Does not disappear on a retry.
    Permanent,
}

/// Error of iceoryx2.
pub(crate) trait Refusal: fmt::Debug {
    fn cause(&self) -> Cause;
}

/// Static texts, because these errors can arise in a tick, where formatting is not allowed.
pub(crate) fn send_text(error: SendError) -> &'static str {
    match error {
        SendError::LoanError(error) => loan_text(error),
        SendError::ConnectionCorrupted => "a connection is damaged",
        SendError::ConnectionError(_) => "a reader cannot be reached",
        _ => "iceoryx2 has an internal error",
    }
}

pub(crate) fn loan_text(error: LoanError) -> &'static str {
    match error {
        LoanError::OutOfMemory => "its shared memory is used up",
        LoanError::ExceedsMaxLoans => "another payload is still being filled",
        _ => "iceoryx2 has an internal error",
    }
}

impl Refusal for StreamOpenOrCreateError {
    fn cause(&self) -> Cause {
        match self {
            Self::SystemInFlux
            | Self::PublishSubscribeOpenError(
                StreamOpenError::HangsInCreation
                | StreamOpenError::IsMarkedForDestruction
                | StreamOpenError::ServiceInCorruptedState
                | StreamOpenError::DoesNotExist,
            )
            | Self::PublishSubscribeCreateError(
                StreamCreateError::AlreadyExists
                | StreamCreateError::HangsInCreation
                | StreamCreateError::IsBeingCreatedByAnotherInstance
                | StreamCreateError::ServiceInCorruptedState,
            ) => Cause::Transient,
            Self::PublishSubscribeOpenError(StreamOpenError::ExceedsMaxNumberOfNodes) => {
                Cause::NoSlot
            }
            _ => Cause::Permanent,
        }
    }
}

impl Refusal for PublisherCreateError {
    fn cause(&self) -> Cause {
        if *self == Self::ExceedsMaxSupportedPublishers {
            Cause::NoSlot
        } else {
            Cause::Permanent
        }
    }
}

impl Refusal for SubscriberCreateError {
    fn cause(&self) -> Cause {
        if *self == Self::ExceedsMaxSupportedSubscribers {
            Cause::NoSlot
        } else {
            Cause::Permanent
        }
    }
}
impl Refusal for ExchangeOpenOrCreateError {
    fn cause(&self) -> Cause {
        match self {
            Self::SystemInFlux
            | Self::RequestResponseOpenError(
                ExchangeOpenError::HangsInCreation
                | ExchangeOpenError::IsMarkedForDestruction
                | ExchangeOpenError::ServiceInCorruptedState
                | ExchangeOpenError::DoesNotExist,
            )
            | Self::RequestResponseCreateError(
                ExchangeCreateError::AlreadyExists
                | ExchangeCreateError::HangsInCreation
                | ExchangeCreateError::IsBeingCreatedByAnotherInstance
                | ExchangeCreateError::ServiceInCorruptedState,
            ) => Cause::Transient,
            Self::RequestResponseOpenError(ExchangeOpenError::ExceedsMaxNumberOfNodes) => {
                Cause::NoSlot
            }
            _ => Cause::Permanent,
        }
    }
}

impl Refusal for ServerCreateError {
    fn cause(&self) -> Cause {
        if *self == Self::ExceedsMaxSupportedServers {
            Cause::NoSlot
        } else {
            Cause::Permanent
        }
    }
}

impl Refusal for ClientCreateError {
    fn cause(&self) -> Cause {
        if *self == Self::ExceedsMaxSupportedClients {
            Cause::NoSlot
        } else {
            Cause::Permanent
        }
    }
}
