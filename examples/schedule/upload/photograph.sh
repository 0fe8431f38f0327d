#!/bin/sh
# Takes so many pictures. Whoever is more important may take the camera in
# between: then this script is stopped, and finds the camera off when it goes on.
set -eu
taken=0
while [ "$taken" -lt "$1" ]; do
    faregate command camera on
    faregate command camera expose
    sleep 1
    taken=$((taken + 1))
done
faregate command camera off
