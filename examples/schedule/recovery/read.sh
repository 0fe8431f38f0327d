#!/bin/sh
# Keeps this sensor on for so many seconds, and says each second that it should
# be: after a pause it is off.
set -eu
read=0
while [ "$read" -lt "$2" ]; do
    faregate command "$1" on
    sleep 1
    read=$((read + 1))
done
faregate command "$1" off
