//! `ebts slurm`: writes scripts that run an experiment in shards on a cluster (Slurm, Kubernetes,
//! GNU parallel).
//!
//! The scripts call `ebts experiment` and `ebts merge`, which provide shards, checkpoints and
//! merge.

mod kubernetes;

use std::path::{Path, PathBuf};

use clap::{Args, Parser};
use serde::Serialize;

use ebts::error::{Error, Result};
use ebts::files::write_atomically;

use super::experiment::ExperimentArgs;
use super::{Format, answer};
use kubernetes::ClusterArgs;

const EXAMPLES: &str = "Example:
  ebts slurm --shards 100 --out big -- fig14 --preset LB3 --seeds 10000
  bash big/submit.sh                        # the array, and a merge that waits for it
  ebts slurm --shards 9 --out k --image registry.example.org/ebts --claim sweeps -- fig14
  kubectl apply -f k/job.json               # and k/merge.json after its end
  cat big/shard-*/runs.jsonl | wc -l        # how many runs are finished";

#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct SlurmArgs {
    /// Number of parts, one array task each.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    shards: u32,
    /// Largest number of concurrent tasks.
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..))]
    at_once: u32,
    /// Threads per task.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: u32,
    /// Folder for the scripts and the runs, on a file system that all nodes share.
    #[arg(long)]
    out: PathBuf,
    #[command(flatten)]
    cluster: ClusterArgs,
    /// Arguments of ebts experiment, without --shard, --out and --threads.
    #[arg(last = true, required = true, value_name = "EXPERIMENT")]
    experiment: Vec<String>,
}

#[derive(Parser)]
#[command(name = "ebts experiment", disable_help_flag = true)]
struct Experiment {
    #[command(flatten)]
    args: ExperimentArgs,
}

#[derive(Serialize)]
struct Written {
    scripts: Vec<PathBuf>,
    runs: usize,
}

pub(super) fn slurm(args: SlurmArgs, format: Format) -> Result<()> {
    let runs = check(&args.experiment)?;
    std::fs::create_dir_all(&args.out).map_err(Error::io("create folder", &args.out))?;
    // Absolute path, because tasks start in other folders.
    let out = args
        .out
        .canonicalize()
        .map_err(Error::io("find folder", &args.out))?;
    let program = std::env::current_exe().map_err(Error::io("find program", &args.out))?;
    let words = args.experiment.iter().map(|word| with_absolute_path(word));
    let words = std::iter::once("experiment".to_owned()).chain(words);
    let arguments: Vec<String> = words.map(|word| quoted(&word)).collect();
    let parts = Parts {
        program: quoted(&program.to_string_lossy()),
        arguments: arguments.join(" "),
        folder: out.to_string_lossy().into_owned(),
        shards: args.shards,
        at_once: args.at_once.min(args.shards),
        threads: args.threads,
        cluster: args.cluster,
    };
    let json = |value| {
        let text = serde_json::to_string_pretty(&value).map_err(Error::from_part);
        text.map(|text| text + "\n")
    };
    let mut scripts = Vec::new();
    for (name, text) in [
        ("shard.sh", parts.shard()),
        ("array.sbatch", parts.array()),
        ("merge.sbatch", parts.merge()),
        ("submit.sh", parts.submit()),
        ("parallel.sh", parts.parallel()),
        ("claim.json", json(parts.claim())?),
        ("job.json", json(parts.indexed_job())?),
        ("merge.json", json(parts.merge_job())?),
    ] {
        let path = args.out.join(name);
        write_atomically(&path, text.as_bytes())?;
        scripts.push(path);
    }
    let written = Written { scripts, runs };
    answer(format, &written, || {
        let out = args.out.display();
        format!(
            "{runs} runs in {} shards\nSlurm:         bash {out}/submit.sh\nGNU parallel:  bash {out}/parallel.sh\n\
             Kubernetes:    kubectl apply -f {out}/job.json, then {out}/merge.json after its end; {out}/claim.json creates a \
             volume if there is none\n\
             progress:      cat {out}/shard-*/runs.jsonl | wc -l\n",
            args.shards
        )
    })
}

/// Rejects invalid experiments before they reach the cluster; returns the number of runs.
fn check(experiment: &[String]) -> Result<usize> {
    let refuse = |was: String| {
        let needs = "arguments of ebts experiment without --shard, --out and --threads";
        Error::refused(
            "write scripts",
            was,
            needs,
            "correct the arguments after --",
        )
    };
    if let Some(own) = experiment.iter().find(|word| {
        ["--shard", "--out", "--threads"]
            .iter()
            .any(|own| word.split('=').next() == Some(own))
    }) {
        return Err(refuse(format!("{own} was given")));
    }
    let words = std::iter::once("ebts experiment").chain(experiment.iter().map(String::as_str));
    let parsed = Experiment::try_parse_from(words).map_err(|error| {
        let message = error.to_string();
        refuse(message.lines().next().unwrap_or_default().to_owned())
    })?;
    if parsed.args.is_of_grasps() {
        return Err(refuse("grasp has no shards that merge".to_owned()));
    }
    let runs = parsed.args.runs;
    Ok(runs.plan(runs.evolution.preset()?)?.jobs().len())
}

/// Replaces the path of an existing file in an argument by its absolute path: `own.toml`,
/// `--preset=own.toml`.
fn with_absolute_path(word: &str) -> String {
    let (option, value) = match word.split_once('=') {
        Some((option, value)) if option.starts_with("--") => (format!("{option}="), value),
        _ => (String::new(), word),
    };
    match Path::new(value).canonicalize() {
        Ok(path) if path.is_file() => format!("{option}{}", path.display()),
        _ => word.to_owned(),
    }
}

fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,".contains(c);
    match !word.is_empty() && word.chars().all(plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

struct Parts {
    /// Path of this program, quoted for a shell.
    program: String,
    /// Its arguments without the shard, quoted for a shell.
    arguments: String,
    folder: String,
    shards: u32,
    at_once: u32,
    threads: u32,
    cluster: ClusterArgs,
}

impl Parts {
    fn out(&self) -> String {
        quoted(&self.folder)
    }

    /// Returns the script of one shard. A restarted shard continues.
    fn shard(&self) -> String {
        let Self {
            program,
            arguments,
            shards,
            threads,
            ..
        } = self;
        let out = self.out();
        format!(
            "#!/usr/bin/env bash\n# usage: shard.sh NUMBER, from 1 to {shards}\nset -eu\n\
             exec {program} {arguments} --threads {threads} --shard \"$1/{shards}\" --out {out}/\"shard-$1\"\n"
        )
    }

    /// Returns the Slurm array script. Slurm sends SIGTERM a minute before the time limit, and on
    /// preemption if so configured. The shard then saves its state and this task alone is queued
    /// again; the job number alone could mean the whole array.
    fn array(&self) -> String {
        let Self {
            shards,
            at_once,
            threads,
            ..
        } = self;
        let out = self.out();
        format!(
            "#!/usr/bin/env bash\n#SBATCH --job-name=ebts\n#SBATCH --array=1-{shards}%{at_once}\n#SBATCH --cpus-per-task={threads}\n\
             #SBATCH --requeue\n#SBATCH --open-mode=append\n#SBATCH --signal=B:TERM@60\n\
             bash {out}/shard.sh \"$SLURM_ARRAY_TASK_ID\" &\nshard=$!\n\
             stop() {{\n    kill -TERM \"$shard\"\n    wait \"$shard\"\n    \
             scontrol requeue \"${{SLURM_ARRAY_JOB_ID}}_${{SLURM_ARRAY_TASK_ID}}\" && exit 0\n    exit 1\n}}\n\
             trap stop TERM\nwait \"$shard\"\n"
        )
    }

    fn merge(&self) -> String {
        let (program, out) = (&self.program, self.out());
        format!(
            "#!/usr/bin/env bash\n#SBATCH --job-name=ebts-merge\nset -eu\n{program} merge {out}/whole {out}/shard-*/\n"
        )
    }

    fn submit(&self) -> String {
        let out = self.out();
        format!(
            "#!/usr/bin/env bash\nset -eu\narray=$(sbatch --parsable {out}/array.sbatch)\n\
             sbatch --kill-on-invalid-dep=yes --dependency=afterok:\"$array\" {out}/merge.sbatch\n"
        )
    }

    fn parallel(&self) -> String {
        let Self {
            shards, threads, ..
        } = self;
        let out = self.out();
        format!(
            "#!/usr/bin/env bash\nset -eu\njobs=$(( ($(nproc) + {threads} - 1) / {threads} ))\n\
             seq {shards} | parallel --jobs \"$jobs\" --joblog {out}/parallel.log bash {out}/shard.sh {{}}\n\
             bash {out}/merge.sbatch\n"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quoted_words_round_trip_through_a_shell() {
        for (word, expected) in [
            ("--seeds", "--seeds"),
            ("", "''"),
            ("a b", "'a b'"),
            ("it's", r"'it'\''s'"),
            ("$x;", "'$x;'"),
        ] {
            assert_eq!(quoted(word), expected);
        }
    }

    fn parts() -> Parts {
        let words = "ebts slurm --shards 2000 --at-once 50 --threads 4 --out x --image r.org/e:1 --claim data -- fig14";
        #[derive(Parser)]
        struct Words {
            #[command(flatten)]
            args: SlurmArgs,
        }
        let args = Words::parse_from(words.split_whitespace().skip(1)).args;
        Parts {
            program: "/bin/ebts".to_owned(),
            arguments: "experiment fig14 --preset 'my own.toml'".to_owned(),
            folder: "/shared/it's big".to_owned(),
            shards: args.shards,
            at_once: args.at_once,
            threads: args.threads,
            cluster: args.cluster,
        }
    }

    #[test]
    fn warned_task_is_requeued_or_fails() {
        let parts = parts();
        let check =
            |text: String, wanted: &str| assert!(text.contains(wanted), "{wanted}:\n{text}");
        check(parts.array(), "--array=1-2000%50\n");
        let queued = "scontrol requeue \"${SLURM_ARRAY_JOB_ID}_${SLURM_ARRAY_TASK_ID}\" && exit 0\n    exit 1\n";
        check(parts.array(), queued);
        check(parts.submit(), "--kill-on-invalid-dep=yes");
        check(parts.parallel(), "($(nproc) + 4 - 1) / 4");
    }

    #[test]
    fn pods_mount_the_claim() {
        let parts = parts();
        let claim = parts.claim();
        assert_eq!(claim["metadata"]["name"], "data");
        assert_eq!(claim["spec"]["accessModes"][0], "ReadWriteMany");
        let indexed = parts.indexed_job();
        let spec = &indexed["spec"];
        assert_eq!(
            (&spec["completions"], &spec["parallelism"]),
            (&2000.into(), &50.into())
        );
        for job in [&indexed, &parts.merge_job()] {
            let pod = &job["spec"]["template"]["spec"];
            let (volume, container) = (&pod["volumes"][0], &pod["containers"][0]);
            assert_eq!(volume["persistentVolumeClaim"]["claimName"], "data");
            let mount = &container["volumeMounts"][0];
            assert_eq!(mount["name"], volume["name"]);
            assert_eq!(
                (&mount["mountPath"], &mount["subPath"]),
                (&"/shared/it's big".into(), &"it's big".into())
            );
            assert_eq!(container["workingDir"], mount["mountPath"]);
            assert_eq!(container["image"], "r.org/e:1");
            let script = container["command"][2].as_str().expect("a script");
            assert!(script.contains(r"'/shared/it'\''s big'/"), "{script}");
        }
    }

    #[test]
    fn file_arguments_become_absolute() {
        let here = std::env::current_dir().expect("a folder");
        let file = here.join("Cargo.toml").display().to_string();
        assert_eq!(with_absolute_path("Cargo.toml"), file);
        assert_eq!(
            with_absolute_path("--preset=Cargo.toml"),
            format!("--preset={file}")
        );
        for word in ["R3", "--preset=R3", "--seeds", "src"] {
            assert_eq!(with_absolute_path(word), word);
        }
    }

    #[test]
    fn invalid_experiments_are_rejected() {
        let check = |text: &str| {
            let words: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
            check(&words).map_err(|error| error.to_string())
        };
        assert_eq!(check("fig14 --seeds 10 --agents 2,3"), Ok(20));
        for (text, expected) in [
            ("fig15", "fig15"),
            ("grasp", "grasp has no shards that merge"),
            ("fig14 --out x", "--out was given"),
            ("fig14 --shard=1/2", "--shard=1/2 was given"),
            ("fig14 --preset R9", "neither a preset nor a file"),
            ("fig14 --agents 5", "could not place 5 agents"),
        ] {
            let message = check(text).expect_err(text);
            assert!(message.contains(expected), "{text}: {message}");
        }
    }
}
