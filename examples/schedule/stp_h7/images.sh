#!/bin/sh
# Takes a picture each second, so many of them, with this camera. On is said each
# time: after a pause the camera is off.
set -eu
taken=0
while [ "$taken" -lt "$2" ]; do
    faregate command "$1" on
    faregate command "$1" expose
    sleep 1
    taken=$((taken + 1))
done
faregate command "$1" off
