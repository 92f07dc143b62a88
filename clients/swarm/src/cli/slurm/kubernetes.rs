//! The same shards and merge as Jobs of Kubernetes, in the JSON that `kubectl apply` reads.
//!
//! Pods are gone when they have ended, so everything lies on a PersistentVolumeClaim that all of them mount in place of the
//! folder; there each sweep has a folder of its own. The program is the image's.

use clap::Args;
use serde_json::{Value, json};

use super::{Parts, quoted};

/// Where pods run, and where their runs stay.
#[derive(Debug, Args)]
pub(super) struct ClusterArgs {
    /// Kubernetes: an image with ebts and sh, and with the files that the experiment names at the same place.
    #[arg(long, default_value = "ebts", value_parser = image)]
    image: String,
    /// Kubernetes: the PersistentVolumeClaim that keeps the runs; the nodes' pods all write to it (ReadWriteMany).
    #[arg(long, default_value = "ebts", value_parser = object_name)]
    claim: String,
}

fn image(text: &str) -> Result<String, String> {
    match !text.is_empty() && text.chars().all(|c| c.is_ascii_graphic()) {
        true => Ok(text.to_owned()),
        false => {
            Err("an image's name has no spaces, as in registry.example.org/ebts:0.1".to_owned())
        }
    }
}

/// What Kubernetes takes for the name of an object (RFC 1123).
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
            "a claim's name has small letters, digits, '-' and '.', as in sweep-data".to_owned(),
        ),
    }
}

impl Parts {
    /// A claim for those who have none. A run takes 1 kB in its shard and again in the merge, what is concluded from a shard 150 kB
    /// (measured): a million runs in 10,000 shards fit twice.
    pub(super) fn claim(&self) -> Value {
        json!({
            "apiVersion": "v1",
            "kind": "PersistentVolumeClaim",
            "metadata": { "name": self.cluster.claim },
            "spec": { "accessModes": ["ReadWriteMany"], "resources": { "requests": { "storage": "10Gi" } } },
        })
    }

    /// One pod for each shard, begun again up to six times: it goes on where it was.
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

    /// The merge, to be applied when the shards have ended.
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
