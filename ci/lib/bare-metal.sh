#!/usr/bin/env bash
# Builds for targets that have no operating system, with whatever compiler is
# here. To be sourced by other scripts:
#
#   source ci/lib/bare-metal.sh
#   bare_cargo thumbv7em-none-eabihf build --release -p faregate-agents ...
#
# bare_cargo TARGET CARGO-ARGUMENTS...
#     Runs cargo for the target. Takes the first compiler that can:
#       1. rustup's, where it has the target installed;
#       2. rustup's with its own sources of core (component rust-src);
#       3. the system's with its own (Debian: rustc-web, rust-web-src).
#     The latter two build core themselves. They are of one version with their
#     sources, so cargo's unstable -Zbuild-std does what it says.
#     Answers 3, and says what is missing, where there is none.
# bare_how TARGET
#     Says which of them it is, in one line; answers 3 where there is none.
# bare_dir TARGET
#     Where the target's files go: its own directory, because two compilers
#     that share one build everything anew each time.
# bare_clippy TARGET
#     Makes sure that `bare_cargo TARGET clippy` works: the lints must be of one
#     version with the compiler.
# bare_packages COMMAND PACKAGE...
#     Makes sure of a command, from Debian's packages where that is possible.
#
# BARE_INSTALL=no: nothing is installed (again).
# BARE_STD names what is built where core is built: core (the default), or std
# for targets with an operating system.

# Exit code: what is needed is not here.
BARE_MISSING=3

BARE_ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)

# The newest feature of the language that we use decides about old compilers.
bare_is_new_enough() {
    local asked have
    asked=$(sed -n 's/^rust-version = "1\.\([0-9]*\)".*/\1/p' "$BARE_ROOT/Cargo.toml")
    have=$("$1" -V 2>/dev/null | sed -n 's/^rustc 1\.\([0-9]*\)\..*/\1/p')
    [[ -n $have && $have -ge $asked ]]
}

bare_sysroot() {
    "$1" --print sysroot 2>/dev/null
}

bare_has_target() {
    compgen -G "$(bare_sysroot "$1")/lib/rustlib/$2/lib/libcore-*.rlib" >/dev/null
}

bare_has_sources() {
    [[ -e $(bare_sysroot "$1")/lib/rustlib/src/rust/library/Cargo.lock ]]
}

# What is installed here, tried in order. Answers "WAY COMPILER".
bare_pick() {
    local target=$1 compiler
    for compiler in rustc /usr/bin/rustc; do
        bare_is_new_enough "$compiler" || continue
        if bare_has_target "$compiler" "$target"; then
            echo "installed $compiler"
            return
        fi
    done
    for compiler in rustc /usr/bin/rustc; do
        bare_is_new_enough "$compiler" || continue
        if bare_has_sources "$compiler"; then
            echo "built $compiler"
            return
        fi
    done
    return "$BARE_MISSING"
}

# Debian's packages, where this is Debian and we may. Quiet where we may not:
# whoever asked says what is missing.
bare_install() {
    [[ ${BARE_INSTALL:-yes} == yes ]] || return "$BARE_MISSING"
    [[ $(id -u) -eq 0 ]] && command -v apt-get >/dev/null || return "$BARE_MISSING"
    echo "installing $*" >&2
    {
        apt-get update && DEBIAN_FRONTEND=noninteractive \
            apt-get install -y --no-install-recommends "$@"
    } >/dev/null 2>&1 || return "$BARE_MISSING"
}

bare_packages() {
    local command=$1
    shift
    command -v "$command" >/dev/null && return
    bare_install "$@" && command -v "$command" >/dev/null && return
    echo "missing: $command; on Debian, as root: apt-get install $*" >&2
    return "$BARE_MISSING"
}

bare_compiler() {
    bare_pick "$1" && return
    bare_install rustc-web rust-web-src && bare_pick "$1" && return
    cat >&2 <<MISSING
missing: a compiler for $1. Any one of these will do:
  rustup target add $1
  rustup component add rust-src
  on Debian, as root: apt-get install rustc-web rust-web-src
MISSING
    return "$BARE_MISSING"
}

bare_how() {
    local picked way compiler version
    picked=$(bare_compiler "$1") || return
    read -r way compiler <<<"$picked"
    version=$("$compiler" -V | cut -d' ' -f1-2)
    if [[ $way == installed ]]; then
        echo "$version, $1 as installed"
    else
        echo "$version, core built from its sources"
    fi
}

bare_dir() {
    echo "${CARGO_TARGET_DIR:-$BARE_ROOT/target}/bare-metal/$1"
}

# Where a linker for bare metal may be: rustup brings one, which is on no PATH.
bare_linker_path() {
    local compiler sysroot host path=
    for compiler in rustc "$1"; do
        sysroot=$(bare_sysroot "$compiler") || continue
        host=$("$compiler" -vV | sed -n 's/^host: //p')
        path+=$sysroot/lib/rustlib/$host/bin:
    done
    echo "$path"
}

# The lints that come with a compiler lie beside it.
bare_lints_of() {
    echo "$(dirname "$(command -v "$1")")/cargo-clippy"
}

bare_clippy() {
    local picked way compiler lints
    picked=$(bare_compiler "$1") || return
    read -r way compiler <<<"$picked"
    lints=$(bare_lints_of "$compiler")
    if [[ $compiler == /usr/bin/rustc && ! -x $lints ]]; then
        bare_install rust-web-clippy || true
    fi
    [[ -x $lints ]] && return
    echo "missing: clippy for $("$compiler" -V); rustup component add clippy," \
        "or on Debian, as root: apt-get install rust-web-clippy" >&2
    return "$BARE_MISSING"
}

bare_cargo() {
    local target=$1 picked way compiler command
    shift
    picked=$(bare_compiler "$target") || return
    read -r way compiler <<<"$picked"
    local arguments=(--target "$target" --target-dir "$(bare_dir "$target")")
    local environment=(RUSTC="$compiler" PATH="$(bare_linker_path "$compiler")$PATH")
    if [[ $way == built ]]; then
        arguments+=("-Zbuild-std=${BARE_STD:-core}")
        environment+=(RUSTC_BOOTSTRAP=1)
    fi
    command=(cargo "$1")
    [[ $1 != clippy ]] || command=("$(bare_lints_of "$compiler")" clippy)
    # The subcommand comes first, and what follows `--` is not cargo's.
    env "${environment[@]}" "${command[@]}" "${arguments[@]}" "${@:2}"
}
