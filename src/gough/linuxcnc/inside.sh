# Inside namespaces of its own, as their root: private folders, the modules, then LinuxCNC without rights.
# $1 the run's folder, $2 the INI's name, $3 how: root or user
set -eu
mount --make-rprivate /
mount --bind "$1" /mnt
cd /mnt
mount --bind /usr/lib/linuxcnc/modules originals
for module in originals/*.so; do
    ln -s "/mnt/$module" "modules/${module##*/}"
done
mount --bind modules /usr/lib/linuxcnc/modules
mount --bind rtapi_app /usr/bin/rtapi_app
mount --bind tmp /tmp
ip link set lo up 2>/dev/null || true
export HOME=/mnt/home TMPDIR=/tmp LD_PRELOAD=/mnt/fastclock.so
unset DISPLAY
if [ "$3" = root ]; then
    exec setpriv --reuid=65534 --regid=65534 --clear-groups --no-new-privs linuxcnc "$2"
fi
exec unshare --user --map-user=65534 --map-group=65534 setpriv --no-new-privs linuxcnc "$2"
