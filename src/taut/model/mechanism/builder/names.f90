!> Names of the parts of a mechanism that is being built: each once, and found again.
submodule(taut_model_mechanism_builder) taut_model_mechanism_builder_names
   implicit none (type, external)

contains

   !> A name must be fit for the header of a table, and no other's.
   module procedure check_name
      integer :: number

      if (len_trim(name) == 0) then
         call raise(self%error, '', 'it has no name', 'give name = "..."')
      else if (verify(trim(name), 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-') > 0) then
         call raise(self%error, '', 'its name has a character that is not allowed', 'use letters, digits, - and _')
      end if
      number = self%anchor_names%find(name)
      ! A point of the ground has no columns.
      if (number > 0 .and. of_joint) then
         if (self%anchors(number)%body == 0) number = 0
      end if
      if (number > 0 .or. name == 'ground' .or. (of_joint .and. self%joint_names%find(name) > 0)) &
         call raise(self%error, '', 'the name is taken: there are two of it', &
                    'rename one of them (bodies, points and joints share the columns of the table)')
   end procedure check_name

   !> Names the part in the error, if something is wrong.
   module procedure locate
      if (.not. allocated(self%error)) return
      if (len(self%error%where) > 0) return
      self%error%where = kind
      if (len_trim(name) > 0) self%error%where = kind//' "'//trim(name)//'"'
   end procedure locate

   !> Notes something that is taken.
   module procedure note
      type(error_t), allocatable :: more(:), one
      integer :: n

      if (allocated(self%error)) return
      n = 0
      if (allocated(self%notes)) n = size(self%notes)
      call raise(one, kind//' "'//trim(name)//'"', what, remedy)
      allocate (more(n + 1))
      if (n > 0) more(:n) = self%notes
      more(n + 1) = one
      call move_alloc(more, self%notes)
   end procedure note

   !> Notes an angle of more than a turn: it may be in degrees.
   module procedure note_angle
      real(wp), parameter :: turn = 2.0_wp*acos(-1.0_wp)

      if (.not. present(angle)) return
      if (abs(angle) <= turn .or. .not. abs(angle) <= huge(angle)) return
      call note(self, kind, name, what//' = '//to_text(angle)//' rad is '//to_text(abs(angle)/turn)//' turns', &
                'angles are in rad; leave it if it is meant')
   end procedure note_angle

   module procedure note_far
      !> In sizes of the body, farther than arms reach, and nearer than millimeters taken for meters.
      real(wp), parameter :: far = 20.0_wp
      real(wp) :: size_of_it

      if (allocated(self%error) .or. number == 0) return
      associate (body => self%bodies(number))
         ! Without a shape, that of the rod with its moments.
         size_of_it = norm2(body%size)
         if (.not. size_of_it > 0.0_wp) size_of_it = sqrt(6.0_wp*(body%j(1, 1) + body%j(2, 2) + body%j(3, 3))/body%m)
         if (.not. (size_of_it > 0.0_wp .and. norm2(p) > far*size_of_it)) return
         call note(self, kind, name, what//' is '//to_text(norm2(p))//' m from the center of "'//body%name// &
                   '", which is '//to_text(size_of_it)//' m large', 'lengths are in m; leave it if it is meant')
      end associate
   end procedure note_far

   !> What may have been meant, before what else to do.
   module procedure meant_of
      text = trim(nearest_name(name, known))
      if (len(text) > 0) text = 'did you mean "'//text//'"? U'
      if (len(text) == 0) text = 'u'
   end procedure meant_of

   !> Adds an anchor.
   module procedure keep_anchor
      type(anchor_t), allocatable :: more(:)

      if (.not. allocated(self%anchors)) allocate (self%anchors(16))
      if (self%anchor_count == size(self%anchors)) then
         allocate (more(2*self%anchor_count))
         more(:self%anchor_count) = self%anchors
         call move_alloc(more, self%anchors)
      end if
      self%anchor_count = self%anchor_count + 1
      self%anchors(self%anchor_count) = anchor
      call self%anchor_names%add(anchor%name, self%anchor_count)
   end procedure keep_anchor

end submodule taut_model_mechanism_builder_names
