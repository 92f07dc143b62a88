//! Kubernetes Jobs for the shards and the merge, as JSON for `kubectl apply`.
//!
//! Files of a pod are lost when it ends. All pods therefore mount a PersistentVolumeClaim in place
//! of the folder; each sweep has its own folder on it. The image contains the program.

use clap::Args;
use serde_json::{Value, json};

use super::{Parts, quoted};

#[derive(Debug, Args)]
pub(super) struct ClusterArgs {
    /// Kubernetes: image with ebts, sh and the files of the experiment at the same paths.
    #[arg(long, default_value = "ebts", value_parser = image)]
    image: String,
    /// Kubernetes: PersistentVolumeClaim for the runs, writable by all pods (ReadWriteMany).
    #[arg(long, default_value = "ebts", value_parser = object_name)]
    claim: String,
}

fn image(text: &str) -> Result<String, String> {
    match !text.is_empty() && text.chars().all(|c| c.is_ascii_graphic()) {
        true => Ok(text.to_owned()),
        false => Err("an image name has no spaces, as in registry.example.org/ebts:0.1".to_owned()),
    }
}

/// Validates the name of a Kubernetes object (RFC 1123).
fn object_name(text: &str) -> Result<String, String> {
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit();
    let label = |label: &str| {
        label.starts_with(plain)
            && label.ends_with(plain)
            && label.chars().all(|c| plain(c) || c == '-')
    };
    match text.len() <= 253 && text.split('.').all(label) {
        true => Ok(text.to_owned()),
        false => Err(
            "a claim name has lower-case letters, digits, '-' and '.', as in sweep-data".to_owned(),
        ),
    }
}

impl Parts {
    /// Returns a claim for clusters without one. Measured: a run takes 1 kB in its shard and again
    /// in the merge; the results of a shard take 150 kB. A million runs in 10,000 shards fit twice.
    pub(super) fn claim(&self) -> Value {
        json!({
            "apiVersion": "v1",
            "kind": "PersistentVolumeClaim",
            "metadata": { "name": self.cluster.claim },
            "spec": { "accessModes": ["ReadWriteMany"], "resources": { "requests": { "storage": "10Gi" } } },
        })
    }

    /// Returns a Job with one pod per shard, restarted up to six times; a restarted shard
    /// continues.
    pub(super) fn indexed_job(&self) -> Value {
        let Self {
            arguments,
            folder,
            shards,
            threads,
            ..
        } = self;
        let out = quoted(folder);
        let script = format!(
            "shard=$((JOB_COMPLETION_INDEX + 1))\n\
             exec ebts {arguments} --threads {threads} --shard \"$shard/{shards}\" --out {out}/\"shard-$shard\""
        );
        let mut spec = self.pod("ebts", &script);
        spec["completionMode"] = "Indexed".into();
        spec["completions"] = (*shards).into();
        spec["parallelism"] = self.at_once.into();
        spec["backoffLimitPerIndex"] = 6.into();
        job("ebts", &spec)
    }

    pub(super) fn merge_job(&self) -> Value {
        let out = quoted(&self.folder);
        let script = format!("exec ebts merge {out}/whole {out}/shard-*/");
        job("ebts-merge", &self.pod("merge", &script))
    }

    fn pod(&self, name: &str, script: &str) -> Value {
        let Self {
            folder,
            cluster: ClusterArgs { image, claim },
            ..
        } = self;
        let own_folder = folder.rsplit('/').next();
        let container = json!({
            "name": name,
            "image": image,
            "command": ["sh", "-c", script],
            "workingDir": folder,
            "resources": { "requests": { "cpu": self.threads } },
            "volumeMounts": [{ "name": "runs", "mountPath": folder, "subPath": own_folder }],
        });
        json!({ "template": { "spec": {
            "restartPolicy": "Never",
            "containers": [container],
            "volumes": [{ "name": "runs", "persistentVolumeClaim": { "claimName": claim } }],
        } } })
    }
}

fn job(name: &str, spec: &Value) -> Value {
    json!({ "apiVersion": "batch/v1", "kind": "Job", "metadata": { "name": name }, "spec": spec })
}
