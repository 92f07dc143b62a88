//! Parameters of the daemon as parameters of the bridge's node.
//!
//! Every parameter of `atas param list` is a number with a range. A change takes effect at the
//! daemon; the answer has its cause if it is rejected.

mod daemon;

use crate::clock::present;
use crate::link::BusLink;
use crate::middleware::{Node, Publish, Quality, Serve};
use crate::wire::Bounded;
use crate::wire::parameters::{
    DescribeParameters, DescribeResponse, Descriptor, FloatRange, GetParameterTypes, GetParameters,
    GetResponse, GetTypesResponse, ListParameters, ListResponse, ListResult, Parameter,
    ParameterEvent, SetAllResponse, SetParameters, SetParametersAtomically, SetResponse, SetResult,
    kind,
};

use daemon::{Known, all, set, value};

/// Largest number of names in one request. Design choice: several times the daemon's parameters.
const NAMES_MAX: usize = 1024;

/// Servers of the parameter services.
pub(crate) struct Parameters {
    node: String,
    get: Box<dyn Serve<GetParameters>>,
    types: Box<dyn Serve<GetParameterTypes>>,
    set: Box<dyn Serve<SetParameters>>,
    set_all: Box<dyn Serve<SetParametersAtomically>>,
    list: Box<dyn Serve<ListParameters>>,
    describe: Box<dyn Serve<DescribeParameters>>,
    events: Box<dyn Publish<ParameterEvent>>,
}

impl Parameters {
    /// Opens the services of the node `NAMESPACE/bridge`.
    ///
    /// # Errors
    /// The middleware fails.
    pub(crate) fn open(node: &mut Node, namespace: &str) -> anyhow::Result<Self> {
        let name = format!("{namespace}/bridge");
        let of = |service: &str| format!("{name}/{service}");
        Ok(Self {
            get: node.server(&of("get_parameters"))?,
            types: node.server(&of("get_parameter_types"))?,
            set: node.server(&of("set_parameters"))?,
            set_all: node.server(&of("set_parameters_atomically"))?,
            list: node.server(&of("list_parameters"))?,
            describe: node.server(&of("describe_parameters"))?,
            events: node.publisher("/parameter_events", Quality::EVENTS)?,
            node: name,
        })
    }

    /// Answers all requests.
    pub(crate) fn poll(&mut self, link: &mut BusLink) {
        if let Err(error) = self.answer(link) {
            tracing::warn!("parameters: {error:#}");
        }
    }

    fn answer(&mut self, link: &mut BusLink) -> anyhow::Result<()> {
        if let Some((caller, request)) = self.get.take()? {
            let values = each(&request.names, |name| value(link, name));
            self.get.respond(caller, GetResponse { values })?;
        }
        if let Some((caller, request)) = self.types.take()? {
            let types = each(&request.names, |name| value(link, name).r#type);
            self.types.respond(caller, GetTypesResponse { types })?;
        }
        if let Some((caller, request)) = self.set.take()? {
            let parameters = request.parameters.iter().take(NAMES_MAX);
            let results = parameters.map(|of| self.change(link, of)).collect();
            self.set.respond(caller, SetResponse { results })?;
        }
        if let Some((caller, request)) = self.set_all.take()? {
            let result = self.change_all(link, &request.parameters);
            self.set_all.respond(caller, SetAllResponse { result })?;
        }
        if let Some((caller, request)) = self.list.take()? {
            let result = listed(&all(link), &request.prefixes, request.depth);
            self.list.respond(caller, ListResponse { result })?;
        }
        if let Some((caller, request)) = self.describe.take()? {
            let known = all(link);
            let descriptors = each(&request.names, |name| descriptor(&known, name));
            self.describe
                .respond(caller, DescribeResponse { descriptors })?;
        }
        Ok(())
    }

    fn change(&self, link: &mut BusLink, parameter: &Parameter) -> SetResult {
        match set(link, parameter) {
            Ok(_) => {
                self.announce(std::slice::from_ref(parameter));
                result(Ok(()))
            }
            Err(reason) => result(Err(reason)),
        }
    }

    /// Changes all parameters, or restores those already changed.
    fn change_all(&self, link: &mut BusLink, parameters: &[Parameter]) -> SetResult {
        let mut before: Vec<Parameter> = Vec::new();
        for parameter in parameters.iter().take(NAMES_MAX) {
            let old = value(link, &parameter.name);
            match set(link, parameter) {
                Ok(()) => before.push(Parameter {
                    name: parameter.name.clone(),
                    value: old,
                }),
                Err(reason) => {
                    let lost = before.iter().rev().find_map(|old| set(link, old).err());
                    let not_restored = lost.map_or(String::new(), |why| {
                        format!("; earlier changes were not undone: {why}")
                    });
                    return result(Err(format!("{reason}{not_restored}")));
                }
            }
        }
        self.announce(parameters);
        result(Ok(()))
    }

    fn announce(&self, changed: &[Parameter]) {
        let event = ParameterEvent {
            stamp: present(),
            node: self.node.clone(),
            changed_parameters: changed.to_vec(),
            ..ParameterEvent::default()
        };
        if let Err(error) = self.events.publish(event) {
            tracing::warn!("parameter event not published: {error:#}");
        }
    }
}

fn each<T>(names: &[String], of: impl FnMut(&String) -> T) -> Vec<T> {
    names.iter().take(NAMES_MAX).map(of).collect()
}

fn result(changed: Result<(), String>) -> SetResult {
    SetResult {
        successful: changed.is_ok(),
        reason: changed.err().unwrap_or_default(),
    }
}

/// Selects the names below prefixes, at most `depth` levels deep (0: any).
fn listed(known: &[Known], prefixes: &[String], depth: u64) -> ListResult {
    let is_listed = |name: &str| {
        let levels = |rest: &str| rest.split('.').count() as u64;
        let below = |prefix: &String| {
            name.strip_prefix(prefix.as_str())
                .and_then(|rest| rest.strip_prefix('.'))
                .is_some_and(|rest| depth == 0 || levels(rest) <= depth)
        };
        let whole = prefixes.is_empty() && (depth == 0 || levels(name) <= depth);
        whole
            || prefixes
                .iter()
                .any(|prefix| prefix == name || below(prefix))
    };
    let names: Vec<String> = known
        .iter()
        .map(|of| of.name.clone())
        .filter(|name| is_listed(name))
        .collect();
    let mut found: Vec<String> = names
        .iter()
        .filter_map(|name| Some(name.rsplit_once('.')?.0.to_owned()))
        .collect();
    found.sort_unstable();
    found.dedup();
    ListResult {
        names,
        prefixes: found,
    }
}

fn descriptor(known: &[Known], name: &str) -> Descriptor {
    let Some(of) = known.iter().find(|of| of.name == name) else {
        return Descriptor {
            name: name.to_owned(),
            ..Descriptor::default()
        };
    };
    Descriptor {
        name: name.to_owned(),
        r#type: kind::DOUBLE,
        description: of.meaning.clone(),
        floating_point_range: Bounded(vec![FloatRange {
            from_value: of.reply.lower,
            to_value: of.reply.upper,
            step: 0.0,
        }]),
        ..Descriptor::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shm_schemas::ControlReply;

    #[test]
    fn names_are_listed_by_prefix_and_depth() {
        let known = ["grasp.dr_n", "grasp.f2.max_n", "safety.pause_s"].map(|name| Known {
            name: name.to_owned(),
            meaning: String::new(),
            reply: ControlReply::default(),
        });
        let check = |prefixes: &[&str], depth, expected: &[&str]| {
            let prefixes: Vec<String> = prefixes.iter().map(|p| (*p).to_owned()).collect();
            assert_eq!(
                listed(&known, &prefixes, depth).names,
                expected,
                "{prefixes:?} {depth}"
            );
        };
        check(&[], 0, &["grasp.dr_n", "grasp.f2.max_n", "safety.pause_s"]);
        check(&[], 2, &["grasp.dr_n", "safety.pause_s"]);
        check(&["grasp"], 0, &["grasp.dr_n", "grasp.f2.max_n"]);
        check(&["grasp"], 1, &["grasp.dr_n"]);
        check(&["gras"], 0, &[]);
        check(&["safety.pause_s"], 1, &["safety.pause_s"]);
        let found = listed(&known, &[], 0).prefixes;
        assert_eq!(found, ["grasp", "grasp.f2", "safety"]);
    }
}
