//! Distances by rooms: within each room from its doors, and between rooms over the graph of the doors.
//!
//! ```text
//! doors: nodes with a neighbour in another room;   w(p, q) = hops within the room, or 1 through the wall
//! D_p = cheapest way from door p to the goal over w                    (coarse, Dijkstra)
//! d_i = min(hops to the goal if it is in the room of i, min_p hops within the room to door p + D_p)
//! ```
//!
//! A shortest way is a sequence of stretches within rooms, so d is the exact cost-to-go.

use crate::partition::Partition;
use eigentrail::graph::SymmetricCsr;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

/// A room's nodes, doors, and the hops from each door to each node within the room.
struct Room {
    nodes: Vec<usize>,
    /// (door, hops by place in `nodes`).
    from_doors: Vec<(usize, Vec<u32>)>,
}

/// The graph as rooms.
pub struct Hierarchy<'a> {
    graph: &'a SymmetricCsr,
    partition: &'a Partition,
    /// Place of a node in its room.
    place: Vec<usize>,
    rooms: Vec<Room>,
}

impl<'a> Hierarchy<'a> {
    pub fn new(graph: &'a SymmetricCsr, partition: &'a Partition) -> Self {
        let mut nodes = vec![Vec::new(); partition.num_rooms];
        let mut place = vec![0; graph.num_nodes()];
        for (i, &room) in partition.room_of.iter().enumerate() {
            place[i] = nodes[room].len();
            nodes[room].push(i);
        }
        let rooms = nodes.into_iter().map(|nodes| Room {
            nodes,
            from_doors: Vec::new(),
        });
        let mut hierarchy = Self {
            graph,
            partition,
            place,
            rooms: rooms.collect(),
        };
        (0..partition.num_rooms).for_each(|room| hierarchy.survey(room));
        hierarchy
    }

    pub fn num_doors(&self) -> usize {
        self.rooms.iter().map(|room| room.from_doors.len()).sum()
    }

    /// Measures a room again, as after a new node or edge in it.
    pub fn survey(&mut self, room: usize) {
        let doors: Vec<usize> = self.rooms[room]
            .nodes
            .iter()
            .copied()
            .filter(|&i| self.is_door(i))
            .collect();
        self.rooms[room].from_doors = doors
            .into_iter()
            .map(|door| (door, self.hops_within(door)))
            .collect();
    }

    fn neighbors(&self, i: usize) -> impl Iterator<Item = usize> + '_ {
        self.graph.row(i).0.iter().map(|&j| j as usize)
    }

    fn is_door(&self, i: usize) -> bool {
        let room = |i: usize| self.partition.room_of[i];
        self.neighbors(i).any(|j| room(j) != room(i))
    }

    /// Hops from `start` to the nodes of its room, by place.
    fn hops_within(&self, start: usize) -> Vec<u32> {
        let room = self.partition.room_of[start];
        let mut hops = vec![u32::MAX; self.rooms[room].nodes.len()];
        hops[self.place[start]] = 0;
        let mut queue = VecDeque::from([start]);
        while let Some(i) = queue.pop_front() {
            for j in self
                .neighbors(i)
                .filter(|&j| self.partition.room_of[j] == room)
            {
                if hops[self.place[j]] == u32::MAX {
                    hops[self.place[j]] = hops[self.place[i]] + 1;
                    queue.push_back(j);
                }
            }
        }
        hops
    }

    /// d of every node, for any goal: O(doors² of each room + nodes × doors of their room).
    pub fn distances(&self, goal: usize) -> Vec<f64> {
        let goal_room = self.partition.room_of[goal];
        let from_goal = self.hops_within(goal);
        let to_goal = self.doors_to_goal(goal_room, &from_goal);
        let mut distances = vec![f64::INFINITY; self.graph.num_nodes()];
        for (number, room) in self.rooms.iter().enumerate() {
            for (place, &i) in room.nodes.iter().enumerate() {
                let over_doors = room
                    .from_doors
                    .iter()
                    .map(|(door, hops)| u64::from(hops[place]) + to_goal[*door]);
                let direct = (number == goal_room).then(|| u64::from(from_goal[place]));
                distances[i] = over_doors
                    .chain(direct)
                    .min()
                    .map_or(f64::INFINITY, |d| d as f64);
            }
        }
        distances
    }

    /// D by node; only doors have one.
    fn doors_to_goal(&self, goal_room: usize, from_goal: &[u32]) -> Vec<u64> {
        let mut best = vec![u64::from(u32::MAX); self.graph.num_nodes()];
        let mut heap = BinaryHeap::new();
        for (door, _) in &self.rooms[goal_room].from_doors {
            best[*door] = u64::from(from_goal[self.place[*door]]);
            heap.push(Reverse((best[*door], *door)));
        }
        while let Some(Reverse((distance, door))) = heap.pop() {
            if distance > best[door] {
                continue;
            }
            let room = self.partition.room_of[door];
            let of_room = &self.rooms[room].from_doors;
            let within = of_room
                .iter()
                .map(|(other, hops)| (*other, u64::from(hops[self.place[door]])));
            let across = self
                .neighbors(door)
                .filter(|&j| self.partition.room_of[j] != room)
                .map(|j| (j, 1));
            for (other, step) in within.chain(across) {
                if distance + step < best[other] {
                    best[other] = distance + step;
                    heap.push(Reverse((distance + step, other)));
                }
            }
        }
        best
    }
}
