#!/bin/sh
# Keeps this processor busy for so many seconds. On is said each time: after a
# pause the processor is off.
set -eu
done=0
while [ "$done" -lt "$2" ]; do
    faregate command "$1" on
    faregate command "$1" load 100
    sleep 1
    done=$((done + 1))
done
faregate command "$1" off
